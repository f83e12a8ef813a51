// Makes the KTX2 files of this folder with Basis Universal's own encoder, and decodes them with its own transcoder: the
// .rgba files have the texels of all levels that the test expects. In an empty folder outside of this one:
//   npm install ktx2-encoder three && pip install astc-encoder-py numpy
//   cp node_modules/three/examples/jsm/libs/basis/basis_transcoder.js basis_transcoder.cjs
//   cp THIS_FOLDER/*.mjs THIS_FOLDER/*.py . && node make.mjs && python3 decode_srgb.py && cp *.ktx2 *.rgba THIS_FOLDER
import { encodeToKTX2 } from "ktx2-encoder";
import fs from "fs";
import { createRequire } from "module";

const require = createRequire(import.meta.url);
const basis = await require("./basis_transcoder.cjs")({
  wasmBinary: fs.readFileSync("node_modules/three/examples/jsm/libs/basis/basis_transcoder.wasm"),
});
basis.initializeBasis();
const ASTC = 10, RGBA8 = 13;

// Ramps with a flat corner and some noise, so that every kind of block and of run occurs.
function picture(width, height, alpha) {
  const data = new Uint8Array(width * height * 4);
  let random = 12345;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      random = (random * 1103515245 + 12345) & 0x7fffffff;
      const flat = x < width / 2 && y < height / 2, noise = flat ? 0 : (random >> 16) % 64;
      const color = flat ? [200, 60, 30] : [(x * 8 + noise) & 255, (y * 12) & 255, ((x ^ y) * 7 + noise) & 255];
      data.set([...color, alpha ? 255 - ((x * y + noise) & 255) : 255], (y * width + x) * 4);
    }
  }
  return { width, height, data };
}

function decode(file, name, target) {
  const ktx = new basis.KTX2File(new Uint8Array(file));
  if (!ktx.isValid() || !ktx.startTranscoding()) throw new Error(name);
  const levels = [];
  for (let level = 0; level < ktx.getLevels(); ++level) {
    const bytes = new Uint8Array(ktx.getImageTranscodedSizeInBytes(level, 0, 0, target));
    if (!ktx.transcodeImage(bytes, level, 0, 0, target, 0, -1, -1)) throw new Error(name);
    levels.push(bytes);
  }
  return levels;
}

function write(name, file) {
  fs.writeFileSync(`${name}.ktx2`, file);
  fs.writeFileSync(`${name}.rgba`, Buffer.concat(decode(file, name, RGBA8)));
  if (name.startsWith("uastc")) fs.writeFileSync(`${name}.astc`, Buffer.concat(decode(file, name, ASTC)));
}

async function encode(name, image, options) {
  const file = await encodeToKTX2(new Uint8Array([0]), { imageDecoder: async () => image, ...options });
  write(name, file);
  return file;
}

// A file of one level whose blocks are random, of all modes and patterns in turn: most of what an encoder never writes.
function allModes(like) {
  const codes = [[4, 1], [6, 53], [5, 29], [5, 3], [5, 19], [5, 11], [5, 27], [5, 7], [5, 23], [5, 15],
                 [3, 2], [2, 0], [3, 6], [5, 31], [5, 13], [7, 5], [6, 21], [6, 37], [4, 9]];
  const patterns = { 2: [20, 30, 5], 3: [20, 11, 4], 4: [20, 30, 5], 7: [20, 19, 5], 9: [28, 30, 5], 16: [29, 30, 5] };
  const bytes = new Uint8Array(like);
  const start = Number(new DataView(bytes.buffer, bytes.byteOffset).getBigUint64(80, true));
  let random = 99;
  for (let block = 0; start + 16 * block < bytes.length; ++block) {
    const mode = block % codes.length;
    let bits = 0n;
    for (let i = 0; i < 8; ++i) {
      random = (random * 1103515245 + 12345) & 0x7fffffff;
      bits = (bits << 16n) | BigInt((random >> 12) & 0xffff);
    }
    const put = (at, count, value) => {
      const mask = ((1n << BigInt(count)) - 1n) << BigInt(at);
      bits = (bits & ~mask) | (BigInt(value) << BigInt(at));
    };
    put(0, ...codes[mode]);
    if (mode in patterns) {
      const [at, count, size] = patterns[mode];
      put(at, size, Math.floor(block / codes.length) % count);
    }
    for (let i = 0; i < 16; ++i) bytes[start + 16 * block + i] = Number((bits >> BigInt(8 * i)) & 255n);
  }
  return bytes;
}

const common = { generateMipmap: true, isSetKTX2SRGBTransferFunc: true };
await encode("etc1s", picture(32, 20, false), { ...common, isUASTC: false });
await encode("etc1s_alpha", picture(64, 64, true), { ...common, isUASTC: false, qualityLevel: 255 });
await encode("etc1s_one_level", picture(16, 16, false), { ...common, isUASTC: false, generateMipmap: false });
await encode("uastc", picture(20, 12, true), { ...common, isUASTC: true, needSupercompression: false });
await encode("uastc_zstd", picture(32, 32, false), { ...common, isUASTC: true, needSupercompression: true });
const plain = await encode("uastc_modes", picture(96, 96, true),
                           { ...common, isUASTC: true, needSupercompression: false, generateMipmap: false });
write("uastc_modes", allModes(plain));
