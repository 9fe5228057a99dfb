#!/usr/bin/env python3
"""Passes frames between two network interfaces, loses some of them and delivers the others late, as `tc netem` would, which not every
kernel has. On Linux, as root:

    lossy_wire.py FIRST SECOND LOSS DELAY SEED

LOSS is the probability that a frame is lost, and DELAY how long a frame takes [s], each in either direction. Equal seeds lose the
same frames of equal traffic. Prints `ready` when it passes frames on, and runs until it is ended.
"""

import random
import selectors
import socket
import sys
import time
from collections import deque

# From linux/if_ether.h, linux/if_packet.h and asm/socket.h.
ETH_P_ALL = 3
PACKET_OUTGOING = 4
SO_RCVBUFFORCE = 33

ETHERNET_HEADER = 14
RECEIVE_BUFFER = 64 << 20


def listen(interface):
    wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
    wire.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, RECEIVE_BUFFER)
    wire.bind((interface, ETH_P_ALL))
    wire.setblocking(False)
    return wire


def without_checksum(frame):
    """Clears the checksum of a UDP datagram in IPv4: the sender left it to its network card, which does not exist."""
    is_udp = len(frame) >= ETHERNET_HEADER + 28 and frame[12:14] == b"\x08\x00" and frame[23] == socket.IPPROTO_UDP
    is_first_fragment = is_udp and frame[20] & 0x1F == 0 and frame[21] == 0
    if not is_first_fragment:
        return frame
    at = ETHERNET_HEADER + 4 * (frame[ETHERNET_HEADER] & 0x0F) + 6
    return frame[:at] + b"\0\0" + frame[at + 2:]


def main():
    first, second = listen(sys.argv[1]), listen(sys.argv[2])
    loss, delay, chance = float(sys.argv[3]), float(sys.argv[4]), random.Random(int(sys.argv[5]))
    selector = selectors.DefaultSelector()
    selector.register(first, selectors.EVENT_READ, second)
    selector.register(second, selectors.EVENT_READ, first)
    # All take equally long, so the first is always due first.
    under_way = deque()
    print("ready", flush=True)
    while True:
        rest = max(0.0, under_way[0][0] - time.monotonic()) if under_way else None
        for key, _ in selector.select(rest):
            frame, (_, _, direction, *_) = key.fileobj.recvfrom(65536)
            # The socket shows what it sends itself, too.
            if direction != PACKET_OUTGOING and chance.random() >= loss:
                under_way.append((time.monotonic() + delay, key.data, without_checksum(frame)))
        while under_way and under_way[0][0] <= time.monotonic():
            _, wire, frame = under_way.popleft()
            try:
                wire.send(frame)
            except OSError as error:
                # A full queue or a frame that is too long is a further loss.
                print(error, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
