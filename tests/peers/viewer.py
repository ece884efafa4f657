#!/usr/bin/env python3
"""What `export foxglove` writes, judged by the viewer's own packages: `viewer.py TRUNNION`. Every check prints a line; the first that
fails ends it.

The schemas in the file are those of `foxglove-schemas-protobuf`; every message is read by its classes. The ball of the table, carried
to the machine through the frames, must lie where the arrow of the same moment begins; arrows and joints are compared with the tables of
`export csv`. The layout has the keys of `foxglove-sdk` and asks for topics that are there.
"""

import csv
import importlib
import io
import json
import math
import pathlib
import tempfile

from foxglove import layouts
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
from mcap.reader import make_reader

from checks import check, trunnion

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOPICS = {"/tf", "/joint_states", "/ball", "/scene", "/errors/measured", "/errors/residual"}


def read(path):
    """Every message by the classes of the viewer, by topic; the schemas on the way."""
    messages, seen = {}, set()
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            if schema.id not in seen:
                seen.add(schema.id)
                same_schema(schema)
            name = schema.name.removeprefix("foxglove.")
            published = getattr(importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name)
            decoded = published.FromString(message.data)
            # A field that the viewer does not know is lost here.
            if len(decoded.SerializeToString()) != len(message.data):
                check(f"{channel.topic}: every field is the viewer's", False, decoded)
            messages.setdefault(channel.topic, []).append((message.log_time, decoded))
    return messages


def same_schema(schema):
    ours, unlike = FileDescriptorSet.FromString(schema.data), []
    for file in (file for file in ours.file if file.package == "foxglove"):
        module = file.name.removesuffix(".proto").split("/")[-1]
        published = FileDescriptorProto()
        importlib.import_module(f"foxglove_schemas_protobuf.{module}_pb2").DESCRIPTOR.CopyToProto(published)
        unlike += [file.name] * (stripped(file) != stripped(published))
    check(f"{schema.name}: the schema and what it imports are as published", not unlike, unlike)


def stripped(file):
    file.ClearField("source_code_info")
    for message in file.message_type:
        for field in message.field:
            field.ClearField("json_name")
    return file


def turned(q, v):
    """v turned by the quaternion q = (x, y, z, w)."""
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def in_machine(frames, frame, place):
    """A place of a frame in machine axes."""
    while frame != "machine":
        parent, translation, rotation = frames[frame]
        place = tuple(a + b for a, b in zip(turned(rotation, place), translation))
        frame = parent
    return place


def xyz(message):
    return (message.x, message.y, message.z)


def scene(messages, table):
    frames, balls = {}, [(at, xyz(ball.pose.position)) for at, ball in messages["/ball"]]
    transforms = {at: message.transforms for at, message in messages["/tf"]}
    (names,) = {tuple(sorted(t.child_frame_id for t in ts)) for ts in transforms.values()}
    check("table and tool are frames, and every axis", {"table", "tool", "X", "Y", "Z", "B", "C"} <= set(names), names)
    worst_m = worst_um = 0.0
    rows = list(csv.DictReader(io.StringIO(table)))
    measured, residual = messages["/errors/measured"], messages["/errors/residual"]
    check("every point has its arrows", len(measured) == len(residual) == len(rows), f"{len(measured)} of {len(rows)}")
    for (at, update), row, (_, other) in zip(measured, rows, residual):
        frames = {t.child_frame_id: (t.parent_frame_id, xyz(t.translation), (t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w))
                  for t in transforms[at]}
        ball = [place for begun, place in balls if begun <= at][-1]
        (arrow,), magnification = update.entities[0].arrows, magnification_of(update)
        begins = in_machine(frames, "table", ball)
        worst_m = max(worst_m, math.dist(begins, xyz(arrow.pose.position)))
        for drawn, what in [(update, "measured"), (other, "residual")]:
            reading_um = math.hypot(*(float(row[f"{what}_{k}_um"]) for k in (1, 2, 3)))
            worst_um = max(worst_um, abs(length_um(drawn) / magnification - reading_um))
    check("each arrow begins where the frames carry the ball", worst_m < 1e-9, f"{worst_m:.1e} m")
    # The table is written to 0.1 nm.
    check("each arrow is as long as its reading, magnified", worst_um < 5e-4, f"{worst_um:.1e} µm")
    whole = magnification_of(measured[0][1])
    check("one magnification for all, and it is round", whole in (10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000), whole)


def magnification_of(update):
    return float({pair.key: pair.value for pair in update.entities[0].metadata}["magnification"])


def length_um(update):
    (arrow,) = update.entities[0].arrows
    return 1e6 * (arrow.shaft_length + arrow.head_length)


def joints(messages, table):
    rows = list(csv.DictReader(io.StringIO(table)))
    worst = 0.0
    for (_, state), row in zip(messages["/joint_states"], rows, strict=True):
        for joint in state.joints:
            length = row.get(f"{joint.name.lower()}_mm")
            expected = float(length) / 1000 if length is not None else math.radians(float(row[f"{joint.name.lower()}_deg"]))
            worst = max(worst, abs(joint.position - expected))
    check("joints are those of the points, in m and rad", worst < 1e-8, f"{worst:.1e}")


def layout(path, topics):
    found = json.loads(path.read_text())
    kinds = {"3D": layouts.ThreeDeeConfig, "Plot": layouts.PlotConfig, "RosOut": layouts.LogConfig, "RawMessages": layouts.RawMessagesConfig}
    for name, config in found["configById"].items():
        known = set(kinds[name.split("!")[0]]()._to_dict())
        check(f"the layout's {name} has the keys of the viewer", set(config) <= known, set(config) - known)
    placed = [part for part in flat(found["layout"]) if "!" in part]
    check("every panel has its place", sorted(placed) == sorted(found["configById"]), placed)
    asked = set(found["configById"]["3D!trunnion"]["topics"]) | {"/joint_states", "/log", "/events"}
    check("the layout asks for topics that are there", asked <= topics, asked - topics)


def flat(node):
    return [node] if isinstance(node, str) else [leaf for key in ("first", "second") for leaf in flat(node[key])]


def live(folder):
    """A recording of the service: the machine moves between the points, and things happen."""
    trunnion("demo", "--static-only", "--hidden", "gravity-sag:B", "--seed", "7", "--output", folder / "demo", "--json")
    whole = folder / "demo/static.mcap"
    trunnion("export", "foxglove", whole, "--model", folder / "demo/static.model.toml", "--magnification", 700, "-o", folder / "live.mcap")
    messages = read(folder / "live.mcap")
    layout(folder / "live.layout.json", set(messages))
    worst, transforms = 0.0, iter(messages["/tf"])
    frames, (at, moved) = {}, next(transforms)
    for drawn_at, update in messages["/errors/residual"]:
        while at <= drawn_at and moved:
            frames = {t.child_frame_id: (t.parent_frame_id, xyz(t.translation), (t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w))
                      for t in moved.transforms}
            at, moved = next(transforms, (at, None))
        ball = [xyz(ball.pose.position) for begun, ball in messages["/ball"] if begun <= drawn_at][-1]
        (arrow,) = update.entities[0].arrows
        worst = max(worst, math.dist(in_machine(frames, "table", ball), xyz(arrow.pose.position)))
    # A dwell is recorded where the axes stand, to some hundredths of a millimetre of the commanded place.
    check("live frames carry the ball to each arrow", worst < 5e-5, f"{1e6 * worst:.1f} µm")
    check("the magnification is as asked", magnification_of(update) == 700)
    log, events = messages["/log"], messages["/events"]
    check("what happened is in the log and among the events", len(log) == len(events) > 100, len(log))
    kinds = {pair.value for _, event in events for pair in event.metadata if pair.key == "kind"}
    check("the cycle begins and ends", {"cycle-start", "cycle-end"} <= kinds, kinds)
    cut = folder / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-20_000])
    trunnion("export", "foxglove", cut, "-o", folder / "cut-view.mcap")
    damage = [line.message for _, line in read(folder / "cut-view.mcap")["/log"] if line.level == 4]
    check("damage of the file is an error of the log", len(damage) == 1 and "cut.mcap" in damage[0], damage)


with tempfile.TemporaryDirectory() as place:
    folder = pathlib.Path(place)
    points = ROOT / "tests/data/points-gravity"
    trunnion("import", points / "points.csv", "--setup", points / "setup.toml", "-o", folder / "run.mcap")
    print(trunnion("export", "foxglove", folder / "run.mcap", "-o", folder / "view.mcap"))
    imported = read(folder / "view.mcap")
    check("the topics are there", TOPICS <= set(imported), sorted(imported))
    scene(imported, trunnion("export", "csv", folder / "run.mcap", "--what", "residuals"))
    joints(imported, trunnion("export", "csv", folder / "run.mcap", "--what", "points"))
    live(folder)
