// node reader.js FOLDER        answers a case;  node reader.js -  those on standard input, as
// node reader.js --golden DIR  counts golden vectors that agree;  `refimpl check --command` asks
const fs = require('fs');
const KINDS = { '<f8': Float64Array, '<f4': Float32Array };
const range = (n) => Array.from({ length: n }, (_, i) => i);
const total = (n, f) => range(n).reduce((sum, i) => sum + f(i), 0);
const needed = (good, words) => { if (!good) throw new Error(`needed ${words}`); };
function readNpy(file) {
  const bytes = fs.readFileSync(file), start = 10 + bytes.readUInt16LE(8);
  const header = bytes.toString('latin1', 10, start), kind = /'descr': '(\S+)'/.exec(header)[1];
  const shape = (/\(([^)]*)\)/.exec(header)[1].match(/\d+/g) || []).map(Number);
  return { kind, shape, data: [...new KINDS[kind](new Uint8Array(bytes.subarray(start)).buffer)] };
}
function write(folder, { shape, data }, kind) {
  const lengths = shape.map((n) => `${n}, `).join('');
  const header = `{'descr': '${kind}', 'fortran_order': False, 'shape': (${lengths}), }`;
  const start = Buffer.from(`\x93NUMPY\x01\x00\x76\x00${header.padEnd(117)}\n`, 'latin1');
  const numbers = Buffer.from(KINDS[kind].from(data).buffer);
  fs.writeFileSync(`${folder}/out0.npy`, Buffer.concat([start, numbers]));
}
const sides = ({ shape }) => { needed(shape.length === 3, 'three axes'); return shape; };
const at = ({ shape: [, C, T], data: y }, n, c, t) => t < 0 || t >= T ? 0 : y[(n * C + c) * T + t];
const made = ([N, C, T], f) => ({ shape: [N, C, T], data: range(N * C * T).map(
  (i) => f(Math.floor(i / C / T), Math.floor(i / T) % C, i % T)) });
const OPERATIONS = {
  conv1d([x, w, b], { stride, padding, dilation, groups }) {
    const [N, C, T] = sides(x), [O, I, K] = sides(w), span = dilation * (K - 1), half = span >> 1;
    const [left, right] = { same: [half, span - half], valid: [0, 0] }[padding]
      || (padding.length === 2 ? padding : [padding, padding]);
    const U = Math.floor((T + left + right - span - 1) / stride) + 1;
    needed(stride > 0 && dilation > 0 && left >= 0 && right >= 0 && C === I * groups && K && O && T
      && (stride === 1 || padding !== 'same') && O % groups === 0 && w.kind === x.kind && U > 0
      && (!b || (b.kind === x.kind && `${b.shape}` === `${O}`)), 'options and shapes that fit');
    return made([N, O, U], (n, o, u) => (b ? b.data[o] : 0) + total(I * K, (i) => {
      const c = Math.floor(i / K), k = i % K, t = u * stride + k * dilation - left;
      return at(w, o, c, k) * at(x, n, I * Math.floor(o * groups / O) + c, t);
    }));
  },
  max_pool1d([x, width], { stride, padding, dilation, ceil_mode }) {
    if (ceil_mode) return '3 ceil_mode';
    const [N, C, T] = sides(x), step = stride ?? width, span = dilation * (width - 1);
    const U = Math.floor((T + 2 * padding - span - 1) / step) + 1;
    needed(width > 0 && step > 0 && 2 * padding <= width && T && U > 0, 'options that fit');
    return made([N, C, U], (n, c, u) => Math.max(...range(width).map((k) => u * step
      + k * dilation - padding).filter((t) => t >= 0 && t < T).map((t) => at(x, n, c, t))));
  },
  relu: ([x]) => ({ shape: x.shape, data: x.data.map((y) => Math.max(y, 0)) }),
  gram: ([h]) => made([sides(h)[0], h.shape[1], h.shape[1]], (n, c, d) => total(h.shape[2],
    (t) => at(h, n, c, t) * at(h, n, d, t))),
  mean_squares([{ shape: [N], data: x }], _, K = x.length / N) {
    needed(K !== 0, 'an element in each clip');
    return { shape: [N], data: range(N).map((n) => total(K, (i) => x[n * K + i] ** 2) / K) };
  },
};
function answer(folder, use) {              // -> the line of the protocol: 0, 3, or 1 and why
  const call = JSON.parse(fs.readFileSync(`${folder}/case.json`)), f = OPERATIONS[call.function];
  const read = ({ array, value }) => (array ? readNpy(`${folder}/${array}.npy`) : value);
  const options = Object.entries(call.attributes).map(([name, { value }]) => [name, value]);
  try {
    const y = f ? f(call.arguments.map(read), Object.fromEntries(options)) : '3';
    return y.data ? use(folder, y, call.precision === 'float64' ? '<f8' : '<f4') || '0' : y;
  } catch (error) { return `1 ${error.message}`; }
}
function compare(folder, { shape, data }, kind) {
  const [y, off] = ['out0', 'allowed0'].map((name) => readNpy(`${folder}/${name}.npy`));
  needed(`${shape}` === `${y.shape}` && [...KINDS[kind].from(data)].every((a, i) => Object.is(
    a, y.data[i]) || Math.abs(a - y.data[i]) <= off.data[i]), 'what is expected');
}
const [how, place] = process.argv.slice(2);
if (how === '--golden') {
  const said = fs.readdirSync(`${place}/vectors`).filter((name) => !name.endsWith('.npz'))
    .map((name) => answer(`${place}/vectors/${name}`, compare)).filter((line) => line[0] !== '3');
  console.log(`${said.filter((line) => line === '0').length} of ${said.length} agree`);
} else if (how === '-') {
  const asked = require('readline').createInterface(process.stdin);
  asked.on('line', (folder) => console.log(answer(folder, write)));
} else {
  const said = answer(how, write);
  console.error(said.slice(2)); process.exit(Number(said[0]));
}
