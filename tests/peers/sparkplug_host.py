"""A host of Sparkplug B over pysparkplug: `sparkplug_host.py PORT`. Prints "ready", then each message of any node as one line of JSON with
the rules that it breaks.

A line `rebirth GROUP NODE` on its input asks that node for its birth; so does a message of a node whose birth it has not seen, as hosts do.
Ends after 60 s without a message.
"""

import json
import queue
import sys
import threading

import paho.mqtt.client as mqtt
import pysparkplug
from pysparkplug import _protobuf as protobuf

KINDS = {
    "NBIRTH": pysparkplug.NBirth, "NDATA": pysparkplug.NData, "NDEATH": pysparkplug.NDeath,
    "DBIRTH": pysparkplug.DBirth, "DDATA": pysparkplug.DData, "DDEATH": pysparkplug.DDeath,
}
REBIRTH = "Node Control/Rebirth"
messages = queue.Queue()


class Node:
    """What the host knows of a node."""

    def __init__(self):
        self.birth, self.devices, self.seq = None, {}, None

    def take(self, message, kind, device):
        problems = []

        def must(is_so, words):
            if not is_so:
                problems.append(words)

        must(not message.retain, "retained")
        must(message.qos == (1 if kind == "NDEATH" else 0), f"QoS {message.qos}")
        raw = protobuf.Payload.FromString(message.payload)
        before = self.devices.get(device) if device else self.birth
        payload = KINDS[kind].decode(message.payload, birth=None if kind.endswith("BIRTH") else before)
        metrics = [payload.bd_seq_metric] if kind == "NDEATH" else getattr(payload, "metrics", ())
        values = {metric.name: metric.value for metric in metrics}
        units = {metric.name: metric.properties.values[0].string_value for metric in raw.metrics if metric.HasField("properties")}
        if kind == "NDEATH":
            must(not raw.HasField("seq"), "a death with seq")
            must(list(values) == ["bdSeq"], "a death with more than bdSeq")
            must(self.birth is None or self.bd_seq() == values["bdSeq"], "a death of another birth")
            self.__init__()
        elif kind == "NBIRTH":
            must(payload.seq == 0, f"born with seq {payload.seq}")
            must(values.get(REBIRTH) is False, "no Rebirth")
            must(isinstance(values.get("bdSeq"), int), "no bdSeq")
            self.birth, self.devices = payload, {}
        else:
            must(self.seq is None or payload.seq == (self.seq + 1) % 256, f"seq {payload.seq} after {self.seq}")
            if kind == "DBIRTH":
                self.devices[device] = payload
            elif kind == "DDEATH":
                must(device in self.devices, "the death of a device that was not born")
                self.devices.pop(device, None)
            elif before is None:
                must(device is None, "data of a device that was not born")
            else:
                named = {metric.name for metric in before.metrics}
                must(set(values) <= named, f"not in the birth: {set(values) - named}")
        if kind != "NDEATH":
            self.seq = payload.seq
        seq = None if kind == "NDEATH" else payload.seq
        return {"kind": kind, "device": device, "seq": seq, "metrics": values, "units": units, "problems": problems}

    def bd_seq(self):
        return next(metric.value for metric in self.birth.metrics if metric.name == "bdSeq")


def ask_for_birth(group, node):
    metric = pysparkplug.Metric(timestamp=pysparkplug.get_current_timestamp(), name=REBIRTH, datatype=pysparkplug.DataType.BOOLEAN, value=True)
    command = pysparkplug.NCmd(timestamp=pysparkplug.get_current_timestamp(), metrics=(metric,))
    client.publish(f"spBv1.0/{group}/NCMD/{node}", command.encode(include_dtypes=True), qos=0)


def orders():
    for line in sys.stdin:
        _rebirth, group, node = line.split()
        ask_for_birth(group, node)


nodes = {}


def connected(client, _data, _flags, _code):
    # Births of the time in between were missed: the nodes that it knew are asked for them.
    known = list(nodes)
    nodes.clear()
    client.subscribe("spBv1.0/#", 1)
    for group, name in known:
        ask_for_birth(group, name)


subscribed = threading.Event()
client = mqtt.Client("host")
client.on_connect = connected
client.on_subscribe = lambda *_: subscribed.set()
client.on_message = lambda _client, _data, message: messages.put(message)
client.reconnect_delay_set(1, 1)
client.connect("127.0.0.1", int(sys.argv[1]))
client.loop_start()
assert subscribed.wait(30), "no broker"
print("ready", flush=True)
threading.Thread(target=orders, daemon=True).start()
while True:
    message = messages.get(timeout=60)
    _namespace, group, kind, name, *device = message.topic.split("/")
    if kind == "NCMD":
        continue
    node = nodes.setdefault((group, name), Node())
    if node.birth is None and kind not in ("NBIRTH", "NDEATH"):
        # Its data cannot be read without it.
        ask_for_birth(group, name)
        continue
    print(json.dumps(node.take(message, kind, device[0] if device else None)), flush=True)
