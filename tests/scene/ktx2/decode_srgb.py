"""Decodes the blocks that make.mjs transcoded to ASTC, by Arm's decoder, as colours in sRGB: NAME_srgb.rgba."""

import pathlib
import struct

import astc_encoder
import numpy

for path in sorted(pathlib.Path(".").glob("uastc*.astc")):
    header = path.with_suffix(".ktx2").read_bytes()[20:44]
    width, height, _, _, _, levels = struct.unpack("<6I", header)
    config = astc_encoder.ASTCConfig(astc_encoder.ASTCProfile.LDR_SRGB, 4, 4)
    context = astc_encoder.ASTCContext(config)
    blocks, texels = path.read_bytes(), b""
    for level in range(max(1, levels)):
        across, down = max(1, width >> level), max(1, height >> level)
        size = 16 * ((across + 3) // 4) * ((down + 3) // 4)
        image = astc_encoder.ASTCImage(astc_encoder.ASTCType.U8, across, down, 1)
        context.decompress(blocks[:size], image, astc_encoder.ASTCSwizzle.from_str("RGBA"))
        blocks = blocks[size:]
        texels += numpy.frombuffer(image.data, numpy.uint8).tobytes()
    path.with_name(path.stem + "_srgb.rgba").write_bytes(texels)
