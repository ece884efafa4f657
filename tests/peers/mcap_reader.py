#!/usr/bin/env python3
"""Reads a recording with the MCAP project's own Python reader and prints what it finds.

    pip install mcap mcap-protobuf-support
    python3 tests/peers/mcap_reader.py run.mcap

Fails when the file has no index, a message does not decode by the embedded schema, the messages are not in
order of log_time, or a probe batch does not add up by the rules written in schema/trunnion.proto.
"""

import collections
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def main(path: str) -> None:
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        assert summary is not None and summary.chunk_indexes, "no index"
        print("attachments:", ", ".join(a.name for a in reader.iter_attachments()) or "none")
        for metadata in reader.iter_metadata():
            print(f"metadata {metadata.name}: {dict(metadata.metadata)}")
        counts, last = collections.Counter(), 0
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            counts[channel.topic, schema.name] += 1
            assert message.log_time >= last or channel.topic == "/run", f"{channel.topic} goes back in time"
            last = message.log_time if channel.topic != "/run" else last
            if schema.name == "trunnion.ProbeBatch":
                samples = len(decoded.raw_delta)
                assert len(decoded.time_ns_delta) == len(decoded.device_ticks_delta) == samples > 0
                counts["samples of", channel.topic] += samples
            if schema.name == "trunnion.Point":
                assert len(decoded.position_mm_rad) == 6 and len(decoded.reading_mm) == 3
        assert sum(n for (a, _), n in counts.items() if a != "samples of") == summary.statistics.message_count
        for (topic, name), count in sorted(counts.items()):
            print(f"{topic:14} {name:26} {count}")


if __name__ == "__main__":
    main(sys.argv[1])
