"""MCAP files of ROS 1 messages, written chunk by chunk and read from beginning to end: https://mcap.dev/spec, profile `ros1`.

A file can be read while it grows, and after its writer was killed: whatever chunks are complete are there.
"""
import os
import struct
import zlib

import lz4.frame

MAGIC = b'\x89MCAP0\r\n'
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, SUMMARY_OFFSET, DATA_END = (
    1, 2, 3, 4, 5, 6, 7, 8, 0x0b, 0x0e, 0x0f)
CHUNK_BYTES = 768 * 1024    # of records in a chunk, as rosbag has it: larger ones make seeking slow, smaller ones the index long
CHUNK_NS = 1_000_000_000    # and no message waits longer than this for its chunk to be written [ns]


class Damaged(Exception):
    """One line for the user."""


def text(value):
    raw = value.encode()
    return struct.pack('<I', len(raw)) + raw


def record(opcode, *content):
    body = b''.join(content)
    return struct.pack('<BQ', opcode, len(body)) + body


def mapping(pairs):
    body = b''.join(pairs)
    return struct.pack('<I', len(body)) + body


def has_header(definition):
    """Whether messages of this text begin with a std_msgs/Header."""
    for line in definition.splitlines():
        words = line.split('#')[0].split()
        if words and '=' not in line.split('#')[0]:
            return words[0] in ('Header', 'std_msgs/Header')
    return False


def stamp_of(data):
    """The header's stamp [ns] of a serialized message that begins with one; 0: it has none."""
    seconds, nanoseconds = struct.unpack_from('<II', data, 4)
    return seconds * 1_000_000_000 + nanoseconds


class Writer:
    """Writes to `file`, a binary file open for writing at its beginning; each chunk is flushed. Times in ns since 1970."""

    def __init__(self, file, library):
        self.file, self.at = file, 0
        self._schemas, self._channels, self._described = {}, {}, []
        self._chunk, self._chunk_size, self._index, self._span = [], 0, {}, None
        self._chunks, self._counts, self._range = [], {}, None
        self._put(MAGIC + record(HEADER, text('ros1'), text(library)))
        file.flush()

    def channel(self, topic, kind, definition, **metadata):
        """Id of the channel of `topic`: messages of type `kind` ('package/Name'), whose full text is `definition`."""
        schema = self._schemas.get((kind, definition))
        if schema is None:
            schema = self._schemas[kind, definition] = len(self._schemas) + 1
            raw = definition.encode()
            self._describe(record(SCHEMA, struct.pack('<H', schema), text(kind), text('ros1msg'), struct.pack('<I', len(raw)), raw))
        key = (topic, schema, tuple(sorted(metadata.items())))
        if key not in self._channels:
            number = self._channels[key] = len(self._channels)
            self._counts[number] = 0
            about = mapping(text(name) + text(value) for name, value in sorted(metadata.items()))
            self._describe(record(CHANNEL, struct.pack('<HH', number, schema), text(topic), text('ros1'), about))
        return self._channels[key]

    def message(self, channel, log_time, publish_time, data):
        if self._chunk_size >= CHUNK_BYTES or self.age(log_time) >= CHUNK_NS:
            self.end_chunk()
        self._span = (min(self._span[0], log_time), max(self._span[1], log_time)) if self._span else (log_time, log_time)
        self._index.setdefault(channel, []).append((log_time, self._chunk_size))
        head = struct.pack('<BQHIQQ', MESSAGE, 22 + len(data), channel, self._counts[channel] & 0xffffffff, log_time, publish_time)
        self._add(head + data)
        self._counts[channel] += 1

    def age(self, now):
        """Of the oldest message that is not written yet [ns]; 0: there is none."""
        return now - self._span[0] if self._span else 0

    def end_chunk(self):
        """Writes what has come since the last chunk."""
        if not self._chunk:
            return
        raw = b''.join(self._chunk)
        packed = lz4.frame.compress(raw, compression_level=0)
        first, last = self._span or (0, 0)  # a chunk of descriptions alone
        begin = self.at
        self._put(record(CHUNK, struct.pack('<QQQI', first, last, len(raw), zlib.crc32(raw)), text('lz4'),
                         struct.pack('<Q', len(packed)), packed))
        length, offsets = self.at - begin, []
        for channel, entries in self._index.items():
            offsets.append(struct.pack('<HQ', channel, self.at))
            self._put(record(MESSAGE_INDEX, struct.pack('<H', channel), mapping(struct.pack('<QQ', *entry) for entry in sorted(entries))))
        self._chunks.append(record(CHUNK_INDEX, struct.pack('<QQQQ', first, last, begin, length), mapping(offsets),
                                   struct.pack('<Q', self.at - begin - length), text('lz4'), struct.pack('<QQ', len(packed), len(raw))))
        if self._span:
            self._range = (min(self._range[0], first), max(self._range[1], last)) if self._range else self._span
        self._chunk, self._chunk_size, self._index, self._span = [], 0, {}, None
        self.file.flush()

    def close(self):
        """Ends the file with its index. It stays open."""
        self.end_chunk()
        self._put(record(DATA_END, struct.pack('<I', 0)))  # 0: no sum over all the data
        start = self.at
        first, last = self._range or (0, 0)
        statistics = record(STATISTICS, struct.pack('<QHIIIIQQ', sum(self._counts.values()), len(self._schemas), len(self._channels), 0, 0,
                                                    len(self._chunks), first, last),
                            mapping(struct.pack('<HQ', *count) for count in self._counts.items()))
        groups = [(code, b''.join(r for r in self._described if r[0] == code)) for code in (SCHEMA, CHANNEL)]
        groups += [(STATISTICS, statistics), (CHUNK_INDEX, b''.join(self._chunks))]
        summary, offsets = b'', b''
        for code, content in groups:
            if content:
                offsets += record(SUMMARY_OFFSET, struct.pack('<BQQ', code, start + len(summary), len(content)))
                summary += content
        footer = struct.pack('<BQQQ', FOOTER, 20, start, start + len(summary))
        self._put(summary + offsets + footer + struct.pack('<I', zlib.crc32(summary + offsets + footer)) + MAGIC)
        self.file.flush()

    def _describe(self, described):
        self._described.append(described)
        self._add(described)  # in the data too: a file without its end says all that its messages need

    def _add(self, content):
        self._chunk.append(content)
        self._chunk_size += len(content)

    def _put(self, content):
        self.file.write(content)
        self.at += len(content)


def _text(body, at):
    end = at + 4 + struct.unpack_from('<I', body, at)[0]
    return body[at + 4:end].decode(), end


def _records(raw, path):
    at = 0
    while at < len(raw):
        opcode, length = struct.unpack_from('<BQ', raw, at)
        if at + 9 + length > len(raw):
            raise Damaged(f'{path}: a chunk ends within a record: the file is damaged')
        yield opcode, raw[at + 9:at + 9 + length]
        at += 9 + length


def _chunk(body, path):
    size, crc = struct.unpack_from('<QI', body, 16)
    compression, at = _text(body, 28)
    packed = body[at + 8:at + 8 + struct.unpack_from('<Q', body, at)[0]]
    if compression not in ('', 'lz4'):
        raise Damaged(f"{path}: compressed by '{compression}'; this program reads lz4 and uncompressed chunks: rewrite it by "
                      "`mcap compress --compression lz4`")
    try:
        raw = lz4.frame.decompress(packed) if compression else packed
    except RuntimeError as error:
        raise Damaged(f'{path}: a chunk cannot be decompressed: the file is damaged') from error
    if len(raw) != size or crc not in (0, zlib.crc32(raw)):
        raise Damaged(f'{path}: the sum over a chunk is wrong: the file is damaged')
    return raw


def messages(path, wanted=lambda topic, kind: True):
    """(topic, kind, definition, metadata, log_time, data) of each message of a channel that `wanted(topic, kind)`, in the order of the
    file; of a file that ends early, those of its complete chunks. Raises Damaged."""
    try:
        yield from _messages(path, wanted)
    except (struct.error, UnicodeDecodeError, KeyError) as error:
        raise Damaged(f'{path}: a record does not hold what its kind says: the file is damaged') from error


def is_complete(path):
    """Whether the file has its end: its writer closed it, and nothing was cut off."""
    with open(path, 'rb') as file:
        file.seek(max(0, file.seek(0, 2) - len(MAGIC)))
        return file.read() == MAGIC and file.tell() > len(MAGIC)


def _messages_at_its_end(path):
    """The number of messages that the statistics of a complete file say; None: it has none."""
    foot = 9 + 20 + len(MAGIC)
    with open(path, 'rb') as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - foot))
        opcode, length, start = struct.unpack('<BQQ', file.read(17))
        at = file.seek(start) if (opcode, length) == (FOOTER, 20) and 0 < start < size else size
        while at + 9 <= size - foot:
            opcode, length = struct.unpack('<BQ', file.read(9))
            if opcode == STATISTICS:
                return struct.unpack('<Q', file.read(8))[0]
            at = file.seek(at + 9 + length)
    return None


def _messages(path, wanted):
    schemas, channels, count = {}, {}, 0
    told = _messages_at_its_end(path) if is_complete(path) else None
    with open(path, 'rb') as file:
        size = file.seek(0, 2)
        file.seek(0)
        if file.read(len(MAGIC)) != MAGIC:
            raise Damaged(f'{path}: is no MCAP file')
        while len(head := file.read(9)) == 9:
            opcode, length = struct.unpack('<BQ', head)
            if opcode in (FOOTER, DATA_END):
                break
            if length > size - file.tell():
                break  # it still grows, its writer was killed, or the number is wrong: the statistics tell
            if opcode not in (SCHEMA, CHANNEL, MESSAGE, CHUNK):
                file.seek(length, 1)
                continue
            body = file.read(length)
            for code, content in _records(_chunk(body, path), path) if opcode == CHUNK else ((opcode, body),):
                if code == SCHEMA:
                    name, at = _text(content, 2)
                    encoding, at = _text(content, at)
                    schemas[struct.unpack_from('<H', content)[0]] = (name, encoding, content[at + 4:])
                elif code == CHANNEL:
                    number, schema = struct.unpack_from('<HH', content)
                    topic, at = _text(content, 4)
                    encoding, at = _text(content, at)
                    metadata, end = {}, at + 4 + struct.unpack_from('<I', content, at)[0]
                    at += 4
                    while at < end:
                        key, at = _text(content, at)
                        metadata[key], at = _text(content, at)
                    kind, schema_encoding, definition = schemas[schema]
                    is_ours = encoding == 'ros1' and schema_encoding == 'ros1msg' and wanted(topic, kind)
                    channels[number] = (topic, kind, definition.decode(), metadata) if is_ours else None
                elif code == MESSAGE:
                    channel, _, log_time, _ = struct.unpack_from('<HIQQ', content)
                    count += 1
                    if channels.get(channel):
                        yield (*channels[channel], log_time, content[22:])
    if told is not None and count != told:
        raise Damaged(f'{path}: {count} of its {told} messages are found: the file is damaged')


def complete_bytes(path):
    """Bytes of a file that ends early up to the end of its last complete record; None: it has its end."""
    if is_complete(path):
        return None
    size, at = os.path.getsize(path), len(MAGIC)
    with open(path, 'rb') as file:
        while True:
            file.seek(at)
            head = file.read(9)
            if len(head) < 9 or at + 9 + struct.unpack('<BQ', head)[1] > size:
                return min(at, size)
            at += 9 + struct.unpack('<BQ', head)[1]


def is_mcap(path):
    try:
        with open(path, 'rb') as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False
