"""The master's side of an update, frame by frame (PROTOCOL.md). It shares no code with the drive's side."""

import zlib

UPDATE_BEGIN, UPDATE_DATA, UPDATE_END, UPDATE_CONFIRM = 0x0AAD52A2, 0x0AAD52A3, 0x0AAD52A5, 0x0AAD52A7
UPDATE_VERSION_REQUEST, UPDATE_STATUS_REQUEST = 0x0AAD54A1, 0x0AAD54A4
UPDATE_VERSION, UPDATE_STATUS = 0x1552A8A1, 0x1552A8A4
IDLE, ERASING, RECEIVING, VERIFYING, MARKED, TRIAL = range(6)
DONE, SEQUENCE, SIGNATURE, REVERTED = 0, 6, 13, 14
HARDWARE = 0x4E58_0001
BLOCK = 6


def words(number):
    return number >> 16 & 0xFFFF, number & 0xFFFF


def status(master):
    """Requests the update status: state, code, window in blocks, offset in bytes."""
    master.seen.pop(UPDATE_STATUS, None)
    ask(master, UPDATE_STATUS_REQUEST, UPDATE_STATUS)
    return last_status(master)


def last_status(master):
    data = master.seen[UPDATE_STATUS]
    return data[0], data[1], int.from_bytes(data[2:4], "big"), int.from_bytes(data[4:8], "big")


def version(master):
    """Requests the version of the running image: major, minor, patch, build."""
    master.seen.pop(UPDATE_VERSION, None)
    ask(master, UPDATE_VERSION_REQUEST, UPDATE_VERSION)
    data = master.seen[UPDATE_VERSION]
    return data[0], data[1], int.from_bytes(data[2:4], "big"), int.from_bytes(data[4:6], "big")


def ask(master, request, answer):
    """Sends a request and waits for its answer.

    Repeats the request with every broadcast: a frame that arrives while the drive restarts is lost.
    """
    asked = None

    def answered():
        nonlocal asked
        if answer not in master.seen and asked != master.broadcasts:
            asked = master.broadcasts
            master.send(request, 0)
        return answer in master.seen

    master.wait(2.0, answered, f"answer {answer:#x}")


def send(master, image, stop_at=None):
    """Sends an image until it is marked for the next boot, or up to the byte `stop_at`."""
    master.seen.pop(UPDATE_STATUS, None)
    master.send(UPDATE_BEGIN, *words(len(image)), *words(HARDWARE))
    master.wait(30.0, lambda: UPDATE_STATUS in master.seen and status(master)[0] == RECEIVING, "slot")
    offset = sent = 0
    while offset < len(image):
        if stop_at is not None and offset >= stop_at:
            return
        state, code, window, offset = last_status(master)
        assert state == RECEIVING and code in (DONE, SEQUENCE), f"state {state}, code {code} at {offset}"
        if code == SEQUENCE:
            sent = offset
        sent = max(sent, offset)
        while sent < min(offset + window * BLOCK, len(image)):
            block = image[sent : sent + BLOCK].ljust(BLOCK, b"\0")
            pairs = [int.from_bytes(block[at : at + 2], "big") for at in (0, 2, 4)]
            master.send(UPDATE_DATA, sent // BLOCK & 0xFFFF, *pairs)
            sent += BLOCK
        before, silent = master.broadcasts, master.seen[UPDATE_STATUS]
        while master.seen[UPDATE_STATUS] is silent and offset < len(image):
            master.pump()
            if master.broadcasts - before > 4:
                status(master)
    master.send(UPDATE_END, *words(zlib.crc32(image)))
    master.wait(20.0, lambda: status(master)[0] != VERIFYING, "verdict")
    assert last_status(master)[0:2] == (MARKED, DONE)


def confirm(master):
    master.send(UPDATE_CONFIRM, 0)
    master.wait(2.0, lambda: status(master)[0:2] == (IDLE, DONE), "confirmation")
