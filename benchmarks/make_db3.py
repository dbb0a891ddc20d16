#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes of an MCAP file without compression (limber convert ... --compression none) a ROS 2 bag in SQLite, as
rosbag2_storage_sqlite3 lays it out, to measure how fast it is read: make_db3.py FILE.mcap FILE.db3
The tests' bag has the same tables (tests/bags/fixtures/make_sqlite_bag.py)."""
import mmap
import pathlib
import sqlite3
import struct
import sys

SCHEMA = """
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (3, 'humble');
"""
MAGIC = 8
SCHEMA_RECORD, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15


def records(data, at, end):
    """(opcode, begin, end) of the records in data[at:end], those in chunks as well."""
    while at < end:
        op, size = struct.unpack_from("<BQ", data, at)
        begin = at + 9
        if op == CHUNK:
            (words,) = struct.unpack_from("<I", data, begin + 28)
            if words:
                sys.exit("the chunks are compressed")
            yield from records(data, begin + 40, begin + size)
        else:
            yield op, begin, begin + size
        if op == DATA_END:
            return
        at = begin + size


def text(data, at):
    (size,) = struct.unpack_from("<I", data, at)
    return data[at + 4 : at + 4 + size].decode(), at + 4 + size


def fill(database, data):
    database.executescript(SCHEMA)
    types = {}
    for op, begin, end in records(data, MAGIC, len(data)):
        (number,) = struct.unpack_from("<H", data, begin)
        if op == SCHEMA_RECORD:
            types[number] = text(data, begin + 2)[0]
        elif op == CHANNEL:
            (schema,) = struct.unpack_from("<H", data, begin + 2)
            topic = text(data, begin + 4)[0]
            database.execute("INSERT OR IGNORE INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, topic, types[schema]))
        elif op == MESSAGE:
            (t_ns,) = struct.unpack_from("<Q", data, begin + 6)
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             (number, t_ns, data[begin + 22 : end]))


def main():
    source, target = map(pathlib.Path, sys.argv[1:])
    target.unlink(missing_ok=True)
    with open(source, "rb") as file, sqlite3.connect(target) as connection:
        fill(connection, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))


if __name__ == "__main__":
    main()
