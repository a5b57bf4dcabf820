// Reads recordings without anything of this project: topics, numbers and fields as the files
// themselves describe them. Prints, as JSON, how many records each topic holds and the SHA-256 of
// every field's values, one after the other, in this form:
//
//   fixed64, sfixed32, double, bool   8, 4, 8 and 1 bytes, little-endian
//   string, bytes                     the number of bytes (4 bytes, little-endian), then the bytes
//   arrays                            the number of values (4 bytes, little-endian), then each
//
// and of the records' sequence numbers and log times, as 8 bytes each. NaN is written as
// 0x7ff8000000000000 (0x7fc00000 in arrays of floats), whatever its payload.
//
//   node read_recording.js FILE...
//
// Every checksum is checked; a damaged file is an error. Exit status 1: a file cannot be read.

import { createHash } from "node:crypto";
import { open } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers, protobufFromBinaryDescriptor } from "@mcap/support";

const CHUNK_BYTES = 1 << 20;

function bytesOf(size, write) {
  const view = new DataView(new ArrayBuffer(size));
  write(view);
  return new Uint8Array(view.buffer);
}

const uint32 = (value) => bytesOf(4, (view) => view.setUint32(0, value, true));
const uint64 = (value) => bytesOf(8, (view) => view.setBigUint64(0, value, true));
const NAN_32 = uint32(0x7fc00000);
const NAN_64 = uint64(0x7ff8000000000000n);

// By protobuf type: one value's bytes. A kind that is not listed is a surprise, and an error.
const SCALARS = {
  fixed64: (value) => uint64((BigInt(value.high >>> 0) << 32n) | BigInt(value.low >>> 0)),
  sfixed32: (value) => bytesOf(4, (view) => view.setInt32(0, value, true)),
  double: (value) =>
    Number.isNaN(value) ? NAN_64 : bytesOf(8, (view) => view.setFloat64(0, value, true)),
  float: (value) =>
    Number.isNaN(value) ? NAN_32 : bytesOf(4, (view) => view.setFloat32(0, value, true)),
  bool: (value) => Uint8Array.of(value ? 1 : 0),
  string: (value) => withLength(new TextEncoder().encode(value)),
  bytes: (value) => withLength(value),
};

function withLength(bytes) {
  return Buffer.concat([uint32(bytes.length), bytes]);
}

function canonical(field, message) {
  const scalar = SCALARS[field.type];
  if (scalar === undefined) {
    throw new Error(`field ${field.name} has the type ${field.type}`);
  }
  const value = message[field.name];
  if (field.repeated) {
    return Buffer.concat([uint32(value.length), ...value.map(scalar)]);
  }
  if (!Object.hasOwn(message, field.name)) {
    throw new Error(`field ${field.name} is left out`);
  }
  return scalar(value);
}

class Topic {
  constructor(schema) {
    if (schema?.encoding !== "protobuf") {
      throw new Error(`a channel's schema is ${schema?.encoding}, not protobuf`);
    }
    this.schema = schema.name;
    this.type = protobufFromBinaryDescriptor(schema.data).lookupType(schema.name);
    this.fields = [...this.type.fieldsArray].sort((a, b) => a.id - b.id);
    this.count = 0;
    this.sequences = createHash("sha256");
    this.logTimes = createHash("sha256");
    this.hashes = this.fields.map(() => createHash("sha256"));
  }

  add(record) {
    const message = this.type.decode(record.data);
    this.count += 1;
    this.sequences.update(uint64(BigInt(record.sequence)));
    this.logTimes.update(uint64(record.logTime));
    this.fields.forEach((field, place) => this.hashes[place].update(canonical(field, message)));
  }

  result() {
    return {
      schema: this.schema,
      count: this.count,
      sequence: this.sequences.digest("hex"),
      log_time: this.logTimes.digest("hex"),
      fields: Object.fromEntries(
        this.fields.map((field, place) => [
          field.name,
          { number: field.id, sha256: this.hashes[place].digest("hex") },
        ]),
      ),
    };
  }
}

class File {
  constructor(handle) {
    this.handle = handle;
  }

  async size() {
    return BigInt((await this.handle.stat()).size);
  }

  async read(offset, length) {
    const buffer = new Uint8Array(Number(length));
    const { bytesRead } = await this.handle.read(buffer, 0, buffer.length, Number(offset));
    if (bytesRead !== buffer.length) {
      throw new Error(`the file ends within ${length} bytes at ${offset}`);
    }
    return buffer;
  }
}

// Reads a file from its beginning to its end; this needs no index.
async function readThrough(file, decompressHandlers) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  const schemas = new Map();
  const channels = new Map();
  const found = { profile: "", metadata: {}, attachments: {}, topics: {} };
  const take = (record) => {
    if (record.type === "Header") {
      found.profile = record.profile;
    } else if (record.type === "Schema") {
      schemas.set(record.id, record);
    } else if (record.type === "Channel" && !channels.has(record.id)) {
      channels.set(record.id, { topic: record.topic, reader: new Topic(schemas.get(record.schemaId)) });
    } else if (record.type === "Message") {
      channels.get(record.channelId).reader.add(record);
    } else if (record.type === "Metadata") {
      found.metadata[record.name] = Object.fromEntries(record.metadata);
    } else if (record.type === "Attachment") {
      found.attachments[record.name] = createHash("sha256").update(record.data).digest("hex");
    }
  };
  const size = Number(await file.size());
  for (let offset = 0; offset < size; offset += CHUNK_BYTES) {
    reader.append(await file.read(offset, Math.min(CHUNK_BYTES, size - offset)));
    for (let record; (record = reader.nextRecord()); ) {
      take(record);
    }
  }
  if (!reader.done()) {
    throw new Error("the file is not complete");
  }
  for (const { topic, reader: each } of channels.values()) {
    found.topics[topic] = each.result();
  }
  return found;
}

// Counts the messages again by way of the index, as tools that jump about in a file read it.
async function countByIndex(file, decompressHandlers) {
  const reader = await McapIndexedReader.Initialize({ readable: file, decompressHandlers });
  const counts = {};
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
  }
  return counts;
}

const decompressHandlers = await loadDecompressHandlers();
const results = [];
for (const path of process.argv.slice(2)) {
  const handle = await open(path);
  try {
    const file = new File(handle);
    const found = await readThrough(file, decompressHandlers);
    results.push({ ...found, counts_by_index: await countByIndex(file, decompressHandlers) });
  } catch (error) {
    console.error(`${path}: ${error.message}`);
    process.exitCode = 1;
  } finally {
    await handle.close();
  }
}
console.log(JSON.stringify(results, null, 1));
