/* .npy files of floating-point numbers, read, written and compared. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#define EACH(i, count) for (long i = 0; i < (count); i++)

typedef struct {
    int axes, bytes;                           /* axes -1: there is none;  bytes: 8 or 4 */
    long n[4], count;
    double *x;
} Array;

static FILE *file_of(const char *folder, const char *name, const char *mode) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return fopen(path, mode);
}

static Array made(int bytes, int axes, long n0, long n1, long n2) {
    long count = n0 * (axes > 1 ? n1 : 1) * (axes > 2 ? n2 : 1);
    return (Array){axes, bytes, {n0, axes > 1 ? n1 : 0, axes > 2 ? n2 : 0}, count,
                   calloc(count + 1, sizeof(double))};
}

static Array read_npy(const char *folder, const char *name) {
    static char room[1 << 20];
    Array a = {-1};
    FILE *file = file_of(folder, name, "rb");
    if (!file) return a;
    const char *end = room + fread(room, 1, sizeof room, file), *header = room + 10;
    const char *numbers = strchr(header, '\n') + 1;
    fclose(file);
    a.axes = sscanf(header, "{'descr': '<f%d', 'fortran_order': False, 'shape': (%ld, %ld, %ld, "
                    "%ld", &a.bytes, &a.n[0], &a.n[1], &a.n[2], &a.n[3]) - 1;
    if (a.axes < 0) return a;
    a.count = (end - numbers) / a.bytes;
    a.x = calloc(a.count + 1, sizeof(double));
    EACH(i, a.count) {
        float single;
        memcpy(a.bytes == 8 ? (void *)&a.x[i] : &single, numbers + i * a.bytes, a.bytes);
        if (a.bytes == 4) a.x[i] = single;
    }
    return a;
}

static void write_npy(const char *folder, const char *name, Array y) {
    FILE *file = file_of(folder, name, "wb");
    fwrite("\x93NUMPY\1\0v", 1, 10, file);                /* a header of 118 bytes */
    fprintf(file, "{'descr': '<f%d', 'fortran_order': False, 'shape': (", y.bytes);
    EACH(i, y.axes) fprintf(file, "%ld, ", y.n[i]);
    fprintf(file, "), }%*s\n", (int)(123 - ftell(file)), "");
    EACH(i, y.count) {
        float single = y.x[i];
        fwrite(y.bytes == 8 ? (void *)&y.x[i] : &single, y.bytes, 1, file);
    }
    fclose(file);
}

static int agrees(const char *folder, Array y) {          /* with a golden vector */
    Array e = read_npy(folder, "out0.npy"), allowed = read_npy(folder, "allowed0.npy");
    long wrong = y.axes != e.axes || memcmp(y.n, e.n, sizeof y.n);
    EACH(i, wrong ? 0 : y.count) {
        double f = y.bytes == 8 ? y.x[i] : (float)y.x[i];
        wrong += !(f == e.x[i] || (f != f && e.x[i] != e.x[i]) || fabs(f - e.x[i]) <= allowed.x[i]);
    }
    return !wrong;
}
