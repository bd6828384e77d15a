"""Images made as PROTOCOL.md and RFC 8032 describe them.

This is an independent implementation of Ed25519ph, so that no signature is compared with itself.
"""

import hashlib
import struct
from pathlib import Path

P, ORDER = 2**255 - 19, 2**252 + 27742317777372353535851937790883648493
D = -121665 * pow(121666, -1, P) % P
SECRET = bytes.fromhex((Path(__file__).parents[2] / "boot" / "keys" / "TEST-ONLY.key").read_text())
BENCH = 0x4E58_0000

Point = tuple[int, int]


def add(a: Point, b: Point) -> Point:
    """Adds two points (section 5.1.4, affine coordinates)."""
    product = D * a[0] * b[0] * a[1] * b[1] % P
    x = (a[0] * b[1] + b[0] * a[1]) * pow(1 + product, -1, P)
    y = (a[1] * b[1] + a[0] * b[0]) * pow(1 - product, -1, P)
    return x % P, y % P


def base() -> Point:
    """Returns the base point: y = 4/5, and the even x (section 5.1)."""
    y = 4 * pow(5, -1, P) % P
    square = (y * y - 1) * pow(D * y * y + 1, -1, P) % P
    x = pow(square, (P + 3) // 8, P)
    if (x * x - square) % P:
        x = x * pow(2, (P - 1) // 4, P) % P
    return (P - x if x % 2 else x), y


def times(scalar: int) -> bytes:
    """Returns an encoded multiple of the base point (section 5.1.2)."""
    total, power = (0, 1), base()
    while scalar:
        if scalar & 1:
            total = add(total, power)
        power, scalar = add(power, power), scalar >> 1
    return (total[1] | (total[0] & 1) << 255).to_bytes(32, "little")


def sign(secret: bytes, message: bytes) -> bytes:
    """Signs a message with Ed25519ph, without a context (section 5.1.6)."""
    domain = b"SigEd25519 no Ed25519 collisions\1\0"
    digest = hashlib.sha512(message).digest()
    expanded = bytearray(hashlib.sha512(secret).digest())
    expanded[0] &= 248
    expanded[31] = expanded[31] & 127 | 64
    scalar = int.from_bytes(expanded[:32], "little")
    nonce = int.from_bytes(hashlib.sha512(domain + expanded[32:] + digest).digest(), "little") % ORDER
    point = times(nonce)
    challenge = hashlib.sha512(domain + point + times(scalar) + digest).digest()
    response = (nonce + int.from_bytes(challenge, "little") * scalar) % ORDER
    return point + response.to_bytes(32, "little")


def image(version: tuple[int, int, int, int], body: bytes, hardware: int = BENCH, secret: bytes = SECRET) -> bytes:
    """Returns a signed image with this program."""
    major, minor, patch, build = version
    head = struct.pack(">8sHHIBBHHHI", b"NARXIMG", 1, 0, hardware, major, minor, patch, build, 0, len(body))
    head = head.ljust(448, b"\0")
    return head + sign(secret, head + body) + body
