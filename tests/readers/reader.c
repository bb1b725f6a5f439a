/* reader FOLDER answers a case, as `refimpl check --command` asks;  reader --golden DIR counts the
   golden vectors of a folder that agree.                          cc -O2 -o reader reader.c -lm */
#include <dirent.h>
#include "npy.h"
#define IS(function) strstr(text, "\"function\": \"" function "\"")
static char text[1 << 16];                                             /* case.json */

static const char *given(const char *name) {                           /* argument or option */
    char keys[2][99], *at;
    sprintf(keys[0], "\"%s\": {\"value\": ", name);
    sprintf(keys[1], "\"name\": \"%s\", \"value\": ", name);
    EACH(i, 2) if ((at = strstr(text, keys[i]))) return at + strlen(keys[i]);
    return "null";
}

static int windows(Array x, Array w, Array b, int pool, Array *y) {    /* conv1d, max_pool1d */
    long stride = atol(given("stride")), dilation = atol(given("dilation")), left, right;
    long C = x.n[1], T = x.n[2], K = pool ? atol(given("width")) : w.n[2], O = pool ? C : w.n[0];
    long I = pool ? 1 : w.n[1], G = pool ? C : atol(given("groups")), span = dilation * (K - 1);
    const char *padding = given("padding"), same = padding[1] == 's';
    char close = ']';
    if (*given("ceil_mode") == 't') return 3;
    if (*given("stride") == 'n') stride = K;
    left = right = *padding == '"' ? 0 : atol(padding);
    if (same) left = span / 2, right = span - left;
    if (*padding == '[') sscanf(padding, "[%ld, %ld%c", &left, &right, &close);
    long rest = T + left + right - span - 1;
    if (x.axes != 3 || stride < 1 || dilation < 1 || left < 0 || K < 1 || T < 1 || rest < 0
        || (pool ? 2 * left > K : w.axes != 3 || w.bytes != x.bytes || C != I * G || !O || O % G)
        || (b.x && (b.axes != 1 || b.n[0] != O || b.bytes != x.bytes)) || close != ']'
        || (same && stride > 1) || padding[1] == 'f') return 1;
    *y = made(x.bytes, 3, x.n[0], O, rest / stride + 1);
    EACH(i, y->count) {
        long u = i % y->n[2], o = i / y->n[2] % O, n = i / y->n[2] / O;
        y->x[i] = pool ? -INFINITY : b.x ? b.x[o] : 0;
        EACH(c, I) EACH(k, K) {
            long t = u * stride + k * dilation - left, inside = t >= 0 && t < T;
            double e = inside ? x.x[(n * C + o * G / O * I + c) * T + t] : 0;
            if (!pool) y->x[i] += w.x[(o * I + c) * K + k] * e;
            else if (inside && (e > y->x[i] || e != e)) y->x[i] = e;
        }
    }
    return 0;
}

static int answer(const char *folder, Array *y) {                      /* -> exit status */
    FILE *file = file_of(folder, "case.json", "rb");
    if (!file) return 3;
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    Array x = read_npy(folder, "in0.npy"), w = read_npy(folder, "in1.npy");
    long N = x.n[0], C = x.n[1], T = x.n[2], size = N ? x.count / N : 1;
    if (IS("conv1d")) return windows(x, w, read_npy(folder, "in2.npy"), 0, y);
    if (IS("max_pool1d")) return windows(x, w, (Array){-1}, 1, y);
    if (!(IS("relu") || IS("gram") || IS("mean_squares"))) return 3;
    if (x.axes < 0 || (IS("gram") && x.axes != 3) || !size) return 1;
    *y = IS("relu") ? x : IS("gram") ? made(x.bytes, 3, N, C, C) : made(x.bytes, 1, N, 1, 1);
    if (IS("relu")) EACH(i, x.count) if (x.x[i] < 0) y->x[i] = 0;
    if (IS("mean_squares")) EACH(i, x.count) y->x[i / size] += x.x[i] * x.x[i] / size;
    if (IS("gram")) EACH(i, y->count) EACH(t, T)
        y->x[i] += x.x[i / C * T + t] * x.x[(i / C / C * C + i % C) * T + t];
    return 0;
}

int main(int count, char **words) {
    static char folder[4096];
    int agree = 0, offered = 0, status = 1;
    Array y;
    if (count == 2 && !(status = answer(words[1], &y))) write_npy(words[1], "out0.npy", y);
    if (count < 3) return status;
    snprintf(folder, sizeof folder, "%s/vectors", words[2]);
    DIR *vectors = opendir(folder);
    for (struct dirent *entry; (entry = readdir(vectors));) {
        snprintf(folder, sizeof folder, "%s/vectors/%s", words[2], entry->d_name);
        if ((status = answer(folder, &y)) == 3) continue;      /* not offered, or no case */
        offered++, agree += !status && agrees(folder, y);
    }
    return printf("%d of %d agree\n", agree, offered) < 0;
}
