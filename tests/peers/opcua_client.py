"""asyncua reads our OPC UA server: `opcua_client.py PORT`. Prints what it read as one line of JSON.

Browses by the names of OPC 40001-101, subscribes to the result and waits for it, holds types against the numbers of that standard, and
tries to write.
"""

import asyncio
import json
import logging
import sys

from asyncua import Client, ua

RESULTS = "http://opcfoundation.org/UA/Machinery/Result/"
logging.disable(logging.CRITICAL)


class Came:
    def __init__(self):
        self.results = asyncio.Queue()

    def datachange_notification(self, node, value, data):
        self.results.put_nowait(value)


async def main(port):
    async with Client(f"opc.tcp://127.0.0.1:{port}/") as client:
        own, standard = [await client.get_namespace_index(name) for name in ("urn:trunnion:service", RESULTS)]
        ours = await client.nodes.objects.get_child(f"{own}:Trunnion")

        async def value(node, *path):
            return await (await node.get_child(list(path))).read_value()

        async def typed(node, number):
            kind = await node.read_type_definition()
            assert kind == ua.NodeId(number, standard), (node, kind)

        management = await ours.get_child(f"{standard}:ResultManagement")
        await typed(management, 1004)
        results = await management.get_child(f"{standard}:Results")
        (result,) = await results.get_children()
        await typed(result, 2001)
        assert await result.read_data_type() == ua.NodeId(3008, standard)
        of_result = await result.get_child(f"{standard}:ResultMetaData")
        assert await of_result.read_data_type() == ua.NodeId(3007, standard)
        identity = await of_result.get_child(f"{standard}:ResultId")
        came = Came()
        watched = await client.create_subscription(50, came)
        await watched.subscribe_data_change(identity)
        while not await asyncio.wait_for(came.results.get(), 30):
            pass
        lists = [await value(result, f"{own}:{name}") for name in ("Symbols", "Values", "Uncertainties", "Units")]
        (content,) = await value(result, f"{standard}:ResultContent")
        details = await value(of_result, f"{standard}:ResultEvaluationDetails")
        try:
            await identity.write_value("another")
            refused = False
        except ua.UaStatusCodeError:
            refused = True
        # Longer than asyncua waits between two looks at the state of the server.
        await asyncio.sleep(1.5)
        read = {name: await value(ours, f"{own}:{name}") for name in ("State", "Run", "Health", "Why")}
        read |= {name: await value(of_result, f"{standard}:{name}") for name in ("ResultId", "ResultEvaluation")}
        read |= {"ResultEvaluationDetails": details.Text, "ResultContent": json.loads(content), "refused": refused,
                 "errors": {symbol: rest for symbol, *rest in zip(*lists, strict=True)}}
        print(json.dumps(read), flush=True)


asyncio.run(main(sys.argv[1]))
