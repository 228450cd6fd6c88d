#!/usr/bin/python3
"""A name server that hears every question and answers none: who asks it waits. For strangers_test.py."""
import socket

with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
    server.bind(("0.0.0.0", 53))
    print("ready", flush=True)
    while True:
        server.recv(4096)
