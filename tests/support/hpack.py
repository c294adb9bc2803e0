# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
#
# Header blocks of HTTP/2 (RFC 7541), as far as tests need them: without Huffman coding, which neither gRPC nor
# HAProxy uses for the fields that tests look at.
STATIC_ENTRIES = 61
STATUS = {8: b"200", 9: b"204", 10: b"206", 11: b"304", 12: b"400", 13: b"404", 14: b"500"}


def field(name, value):
    """A literal field without indexing. Name and value must be shorter than 127 bytes."""
    texts = [name.encode(), value.encode()]
    return b"\0" + b"".join(bytes([len(text)]) + text for text in texts)


class Decoder:
    """Reads the header blocks of one connection, in their order."""

    def __init__(self):
        self.table = []  # the newest first; never shortened, as indices count from the newest

    def decode(self, block):
        """The fields, by name. A text in Huffman coding or of the static table is b"?"."""
        fields, at = {}, 0
        while at < len(block):
            first = block[at]
            if first & 0x80:
                index, at = self.integer(block, at, 7)
                name, value = self.entry(index)
            elif first & 0xE0 == 0x20:  # the table gets another size
                _, at = self.integer(block, at, 5)
                continue
            else:
                is_kept = bool(first & 0x40)
                index, at = self.integer(block, at, 6 if is_kept else 4)
                name = self.entry(index)[0]
                if index == 0:
                    name, at = self.text(block, at)
                value, at = self.text(block, at)
                if is_kept:
                    self.table.insert(0, (name, value))
            fields[name] = value
        return fields

    def entry(self, index):
        if index in STATUS:
            return b":status", STATUS[index]
        at = index - STATIC_ENTRIES - 1
        return self.table[at] if 0 <= at < len(self.table) else (b"?", b"?")

    @staticmethod
    def integer(block, at, bits):
        most = (1 << bits) - 1
        value, shift = block[at] & most, 0
        at += 1
        if value < most:
            return value, at
        while True:
            value += (block[at] & 0x7F) << shift
            shift += 7
            at += 1
            if not block[at - 1] & 0x80:
                return value, at

    def text(self, block, at):
        is_huffman = bool(block[at] & 0x80)
        size, at = self.integer(block, at, 7)
        return b"?" if is_huffman else bytes(block[at : at + size]), at + size
