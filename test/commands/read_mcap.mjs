// Reads an MCAP file by the format's own library: node read_mcap.mjs FOLDER_OF_NODE_MODULES FILE. Prints JSON: messages by topic, gaps in
// their sequence, ticks, and a message that was found by time. An error ends it with its text.
import {createRequire} from 'node:module';
import {open} from 'node:fs/promises';
import {pathToFileURL} from 'node:url';

const require = createRequire(pathToFileURL(process.argv[2] + '/'));
const {McapIndexedReader} = require('@mcap/core');
const lz4 = require('lz4js');

const file = await open(process.argv[3]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, Number(length), Number(offset));
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({readable, decompressHandlers: {lz4: (bytes, size) => lz4.decompress(bytes, Number(size))}});
const topics = {}, lost = {}, last = {};
let messages = 0, ticks = 0n, nextTick = null, ticksMissing = 0n, early = 0, previous = 0n;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId), schema = reader.schemasById.get(channel.schemaId);
  const view = new DataView(message.data.buffer, message.data.byteOffset, message.data.byteLength);
  ++messages;
  topics[channel.topic] = (topics[channel.topic] ?? 0) + 1;
  if (message.logTime < previous) ++early;
  previous = message.logTime;
  // A publisher counts what it sends in the header: a number that is left out is a message that did not come.
  if (/^(std_msgs\/)?Header /m.test(new TextDecoder().decode(schema.data).split('='.repeat(20))[0])) {
    const sequence = view.getUint32(0, true), key = message.channelId;
    if (last[key] !== undefined && sequence > last[key] + 1) lost[channel.topic] = (lost[channel.topic] ?? 0) + sequence - last[key] - 1;
    last[key] = sequence;
  }
  if (schema.name === 'haptic_msgs/TickRecord') {
    const at = 16 + view.getUint32(12, true), first = view.getBigUint64(at, true), count = BigInt(view.getUint32(at + 8, true));
    if (nextTick !== null) ticksMissing += first - nextTick;
    nextTick = first + count;
    ticks += count;
  }
}
const {messageStartTime: start, messageEndTime: end, messageCount} = reader.statistics;
const middle = start + (end - start) / 2n;
let found = null;
for await (const message of reader.readMessages({startTime: middle})) { found = message.logTime; break; }
console.log(JSON.stringify({messages, told: Number(messageCount), topics, lost, early, ticks: Number(ticks), ticksMissing: Number(ticksMissing),
  channels: reader.channelsById.size, chunks: reader.chunkIndexes.length, profile: reader.header.profile,
  schemas: [...reader.schemasById.values()].map(schema => [schema.name, schema.encoding]),
  waited: found === null ? null : Number(found - middle) / 1e9, seconds: Number(end - start) / 1e9}));
