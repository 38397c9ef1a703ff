"""LZF, the compression of PCD files (Marc Lehmann's LibLZF, format described in its lzf_d.c)."""


class LzfError(Exception):
    """Bytes that are not LZF, or not of the length that was stated."""


def decompress(data: bytes, length: int) -> bytes:
    """The `length` bytes that were compressed to `data`.

    A control byte below 32 is followed by so many bytes and one more. Others point back: 3 bits of length (7:
    another byte is added) and 13 bits of distance.
    """
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            count = control >> 5
            if count == 7:
                count += data[at]
                at += 1
            count += 2
            begin = len(out) - ((control & 31) << 8) - data[at] - 1
            at += 1
            if begin < 0:
                raise LzfError("compressed data point before their beginning")
            piece = out[begin : begin + count]
            # A piece that overlaps its own end repeats.
            while len(piece) < count:
                piece += piece[: count - len(piece)]
            out += piece
    except IndexError as error:
        raise LzfError("compressed data end inside a reference") from error
    if len(out) != length:
        raise LzfError(f"compressed data give {len(out)} bytes where {length} were stated")
    return bytes(out)
