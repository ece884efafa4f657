"""asyncua servers for our OPC UA driver.

Arguments: port, layout (sinumerik or opc-40502), security (none or Basic256Sha256), folder for the server's certificate.
Axis k is at 100 + 20·k + 5·sin(0.5·t + k) mm, or 10·sin(0.5·t + k) degrees, t seconds since 1970; its source stamp is
that of its own sampling, STAGGER later from axis to axis. The program "TRUNNION_1" runs from the second second on.
Prints one line when ready; ends with its input. Lines of input: "bad" (axis C has no value), "good", "stand", "move".
"""

import asyncio
import datetime
import logging
import math
import pathlib
import sys
import time

from asyncua import Server, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.permission_rules import SimpleRoleRuleset, User, UserRole
from asyncua.server.user_managers import UserManager
from cryptography.x509.oid import ExtendedKeyUsageOID

PERIOD, STAGGER = 0.01, 0.001
AXES = "XYZBC"
logging.disable(logging.CRITICAL)


class OneUser(UserManager):
    def get_user(self, iserver, username=None, password=None, certificate=None):
        good = username == "measure" and password == "trunnion"
        return User(role=UserRole.User, name=username) if good else None


def position(k, t):
    swing = math.sin(0.5 * t + k)
    return 10 * swing if AXES[k] in "ABC" else 100 + 20 * k + 5 * swing


def stamped(value, t, status=ua.StatusCodes.Good):
    stamp = datetime.datetime.fromtimestamp(t, datetime.timezone.utc)
    return ua.DataValue(value, ua.StatusCode(status), SourceTimestamp=stamp)


async def sinumerik(server):
    index = await server.register_namespace("urn:sinumerik-like")
    assert index == 2

    async def variable(path, value):
        return await server.nodes.objects.add_variable(ua.NodeId(path, index), ua.QualifiedName(path, index), value)

    axes = [await variable(f"/Channel/MachineAxis/measPos1[u1,{k + 1}]", 0.0) for k in range(len(AXES))]
    program = await variable("/Channel/ProgramInfo/progName[u1]", "")
    state = await variable("/Channel/State/progStatus[u1]", ua.Variant(5, ua.VariantType.UInt16))
    return axes, program, state, 3


async def opc_40502(server):
    index = await server.register_namespace("urn:cnc-like")
    cnc = await (await server.nodes.objects.add_object(index, "Machines")).add_object(index, "CncInterface")
    listed = await cnc.add_object(index, "CncAxisList")
    axes = []
    for letter in AXES:
        axis = await listed.add_object(index, letter)
        for kind in ("PosIndirect", "PosDirect"):
            place = await axis.add_object(index, kind)
            actual = await place.add_variable(index, "ActPos", 0.0)
        # UNECE codes DD and MMT, as OPC 10000-8 packs them.
        code = int.from_bytes(b"DD" if letter in "ABC" else b"MMT", "big")
        units = ua.EUInformation("http://www.opcfoundation.org/UA/units/un/cefact", code, ua.LocalizedText("u"))
        await actual.add_property(ua.NodeId(f"eu-{letter}", index), ua.QualifiedName("EngineeringUnits", 0), units)
        axes.append(actual)
    channels = await cnc.add_object(index, "CncChannelList")
    channel = await channels.add_object(index, "Channel1")
    program = await channel.add_variable(index, "ActMainProgramName", "")
    state = await channel.add_variable(index, "ActProgramStatus", ua.Variant(0, ua.VariantType.Int32))
    return axes, program, state, 1


async def main(port, layout, security, folder):
    user_manager = OneUser() if security != "none" else None
    server = Server(user_manager=user_manager)
    await server.init()
    server.set_endpoint(f"opc.tcp://127.0.0.1:{port}/trunnion/")
    server.set_server_name("asyncua " + layout)
    if security == "none":
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    else:
        key, certificate = pathlib.Path(folder, "key.pem"), pathlib.Path(folder, "certificate.der")
        uri, usage = "urn:asyncua:peer", [ExtendedKeyUsageOID.CLIENT_AUTH, ExtendedKeyUsageOID.SERVER_AUTH]
        await server.set_application_uri(uri)
        await setup_self_signed_certificate(key, certificate, uri, "localhost", usage, {"commonName": "peer"})
        policy = ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt
        server.set_security_policy([policy], permission_ruleset=SimpleRoleRuleset())
        await server.load_certificate(str(certificate))
        await server.load_private_key(str(key))
        server.set_identity_tokens([ua.UserNameIdentityToken])
    axes, program, state, running = await (sinumerik if layout == "sinumerik" else opc_40502)(server)
    await server.write_attribute_value(program.nodeid, stamped(ua.Variant("TRUNNION_1"), time.time()))
    orders = {"bad": False, "stand": False}

    async def listen():
        lines = asyncio.StreamReader()
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
        while word := (await lines.readline()).decode().strip():
            orders["bad"] = {"bad": True, "good": False}.get(word, orders["bad"])
            orders["stand"] = {"stand": True, "move": False}.get(word, orders["stand"])

    async with server:
        print("ready", flush=True)
        ended, begun, runs, n = asyncio.ensure_future(listen()), time.time(), False, 0
        while not ended.done():
            if not runs and time.time() > begun + 2:
                runs = True
                variant = ua.Variant(running, ua.VariantType.UInt16 if running == 3 else ua.VariantType.Int32)
                await server.write_attribute_value(state.nodeid, stamped(variant, time.time()))
            for k, axis in enumerate(axes):
                t = time.time() - STAGGER * (len(AXES) - 1 - k)
                bad = orders["bad"] and AXES[k] == "C"
                status = ua.StatusCodes.BadNoCommunication if bad else ua.StatusCodes.Good
                if not orders["stand"] or bad:
                    value = ua.Variant(position(k, t), ua.VariantType.Double)
                    await server.write_attribute_value(axis.nodeid, stamped(value, t, status))
            n += 1
            await asyncio.sleep(max(0.0, begun + n * PERIOD - time.time()))


asyncio.run(main(int(sys.argv[1]), *sys.argv[2:5]))
