#!/usr/bin/env python3
"""Checks a log that 3-D views show, with readers that others made.

    scene_log.py LOG [--largest BYTES] [--layout FILE]

Every message on a topic of Protocol Buffers is decoded by its own schema, schemas of Foxglove's types are those that
Foxglove's SDK has, all frames hang together, and what stands in them is what the JSON topics say: the base's pose, the
thrusts, the forces. What a layout of Foxglove's shows is in the log. Says what it checked; fails at the first
difference.
"""

import argparse
import collections
import json
import pathlib

import foxglove.messages
import numpy as np
from google.protobuf import descriptor_pb2
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

FOXGLOVE = {
    "/tf": "FrameTransforms",
    "/tf_static": "FrameTransforms",
    "/scene": "SceneUpdate",
    "/scene/robot": "SceneUpdate",
    "/reference": "PosesInFrame",
}


def files(data):
    """The files of a set of descriptors by name."""
    found = descriptor_pb2.FileDescriptorSet.FromString(data).file
    return {file.name: file for file in found}


def vector(v):
    return np.array([v.x, v.y, v.z])


def matrix(q):
    """Rotation of a unit quaternion."""
    w, x, y, z = q.w, q.x, q.y, q.z
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def read(path):
    """Schemas and messages of a log by topic: time in ns and contents."""
    schemas, protobuf, texts = {}, collections.defaultdict(list), collections.defaultdict(dict)
    decoders = DecoderFactory()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            schemas[channel.topic] = schema
            if channel.message_encoding == "protobuf":
                decode = decoders.decoder_for("protobuf", schema)
                protobuf[channel.topic].append((message.log_time, decode(message.data)))
            else:
                texts[channel.topic][message.log_time] = message.data
    return schemas, protobuf, texts


def check_schemas(schemas, protobuf):
    for topic, name in FOXGLOVE.items():
        assert protobuf[topic], f"{topic} has no message"
        known = getattr(foxglove.messages, name).get_schema()
        schema = schemas[topic]
        assert (schema.name, schema.encoding) == (known.name, known.encoding), topic
        ours, theirs = files(schema.data), files(known.data)
        assert ours.keys() == theirs.keys(), f"{topic}: {sorted(ours)} instead of {sorted(theirs)}"
        for file, descriptor in theirs.items():
            assert ours[file] == descriptor, f"{topic}: {file} is not what Foxglove has"


def check_frames(protobuf):
    """All frames are reached from the world; whatever is drawn is in one of them."""
    parents = {}
    for topic in ["/tf", "/tf_static"]:
        for t in protobuf[topic][0][1].transforms:
            assert t.child_frame_id not in parents, f"two parents of {t.child_frame_id}"
            parents[t.child_frame_id] = t.parent_frame_id
    for frame in parents:
        seen = []
        while frame != "world":
            assert frame not in seen, f"a ring of frames: {seen}"
            seen.append(frame)
            frame = parents[frame]
    for topic in ["/scene", "/scene/robot"]:
        for _, scene in protobuf[topic]:
            for entity in scene.entities:
                assert entity.frame_id in parents or entity.frame_id == "world", entity.id
    return len(parents)


def check_base(protobuf, texts):
    base = protobuf["/tf"][0][1].transforms[0]
    assert base.parent_frame_id == "world"
    for time, message in protobuf["/tf"]:
        state = json.loads(texts["/state"][time])["base"]
        at, turn = message.transforms[0].translation, message.transforms[0].rotation
        for axis in "xyz":
            assert abs(getattr(at, axis) - state["position"][axis]) < 1e-6, f"base at {time} ns"
        for axis in "wxyz":
            assert abs(getattr(turn, axis) - state["orientation"][axis]) < 1e-6, f"base at {time} ns"
    return len(protobuf["/tf"])


def check_thrusts(protobuf, texts):
    """Arrows of rotors have the commanded thrusts' lengths, one scale for all."""
    scales = []
    for time, scene in protobuf["/scene"]:
        rotors = json.loads(texts["/command"][time])["rotors"]
        for entity in scene.entities:
            kind, _, name = entity.id.partition("/")
            if kind == "rotor" and entity.arrows:
                arrow = entity.arrows[0]
                scales.append((arrow.shaft_length + arrow.head_length) / abs(rotors[name]["thrust"]))
    if scales:
        assert np.ptp(scales) < 1e-5 * np.mean(scales), "thrusts are drawn to different scales"
    return len(scales)


def check_forces(protobuf, texts):
    """Forces in world axes are as long as those in the surface's, and their normal parts are the same."""
    count = 0
    for topic in list(protobuf):
        if not topic.endswith("/forces"):
            continue
        for time, message in protobuf[topic]:
            text = texts[topic.removesuffix("/forces")].get(time)
            if text is None:
                continue
            contact = json.loads(text)
            for ours, theirs in [("planned", "solution"), ("measured", "measured"), ("truth", "truth")]:
                if theirs not in contact:
                    assert not message.HasField(ours)
                    continue
                force = vector(getattr(message, ours))
                local = np.array([contact[theirs][axis] for axis in "xyz"])
                assert abs(np.linalg.norm(force) - np.linalg.norm(local)) < 1e-4, f"{topic} at {time} ns"
                assert abs(force @ vector(message.normal) - local[2]) < 1e-4, f"{topic} at {time} ns"
                count += 1
    return count


def check_arrows(protobuf):
    """Every planned and every true force is an arrow in the scene, at its point and along it."""
    kinds = {"planned": (0.15, 0.4, 0.95), "truth": (0.1, 0.65, 0.2)}
    scenes = dict(protobuf["/scene"])
    count = 0
    for topic in list(protobuf):
        if not topic.endswith("/forces"):
            continue
        entity_id = topic.removesuffix("/forces").lstrip("/")
        for time, message in protobuf[topic]:
            entity = next(entity for entity in scenes[time].entities if entity.id == entity_id)
            for kind, colour in kinds.items():
                force = vector(getattr(message, kind))
                arrows = [a for a in entity.arrows if np.allclose((a.color.r, a.color.g, a.color.b), colour)]
                if not message.active or np.linalg.norm(force) < 1.0:
                    continue
                assert len(arrows) == 1, f"{topic} at {time} ns: {len(arrows)} arrows of {kind}"
                pose = arrows[0].pose
                direction = matrix(pose.orientation)[:, 0]
                assert np.allclose(direction, force / np.linalg.norm(force), atol=1e-5), f"{topic} at {time} ns"
                far = np.linalg.norm(vector(pose.position) - vector(message.position))
                # The measured state's point and the real one.
                assert far < (1e-5 if kind == "planned" else 0.05), f"{topic} at {time} ns: {far} m off"
                count += 1
    return count


def check_layout(layout, schemas, texts):
    """Every topic and field that a layout shows is in the log."""
    fields = 0
    for panel in layout["configById"].values():
        for topic in [*panel.get("topics", {}), *filter(None, [panel.get("topicPath")])]:
            assert topic in schemas, f"the layout shows {topic}"
        for path in panel.get("paths", []):
            topic, *names = path["value"].split(".")
            messages = [json.loads(text) for text in texts[topic].values()]
            assert any(has(message, names) for message in messages), f"the layout shows {path['value']}"
            fields += 1
    return fields


def has(message, names):
    for name in names:
        if name not in message:
            return False
        message = message[name]
    return isinstance(message, (int, float))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log", type=pathlib.Path)
    parser.add_argument("--largest", type=int, help="how large the file may be, bytes")
    parser.add_argument("--layout", type=pathlib.Path, help="a layout that is made for this log")
    arguments = parser.parse_args()
    size = arguments.log.stat().st_size
    assert arguments.largest is None or size <= arguments.largest, f"{arguments.log} has {size} bytes"
    schemas, protobuf, texts = read(arguments.log)
    check_schemas(schemas, protobuf)
    counts = [
        f"{check_frames(protobuf)} frames",
        f"{check_base(protobuf, texts)} poses of the base",
        f"{check_thrusts(protobuf, texts)} thrusts",
        f"{check_forces(protobuf, texts)} forces",
        f"{check_arrows(protobuf)} of their arrows",
    ]
    if arguments.layout:
        layout = json.loads(arguments.layout.read_text())
        counts.append(f"{check_layout(layout, schemas, texts)} fields of the layout")
    print(f"{arguments.log}: {size} bytes; {', '.join(counts)}")


if __name__ == "__main__":
    main()
