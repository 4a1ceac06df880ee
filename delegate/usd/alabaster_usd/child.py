"""The process that reads a stage for a program: python3 -I child.py SITE. Each message of descriptor 3 is one JSON object."""
import array
import fcntl
import json
import os
import socket
import sys

SITE = sys.argv[1] if len(sys.argv) > 1 else ""
sys.path[:0] = [os.path.dirname(os.path.dirname(os.path.abspath(__file__)))] + ([SITE] if SITE else [])
sys.dont_write_bytecode = True
sys.setrecursionlimit(20000)  # prims lie in each other

from alabaster_usd import fence

PROTOCOL = 1
MOST = 60000  # bytes of a message
SEALS = 0x1 | 0x2 | 0x4 | 0x8  # of sealing, shrinking, growing, writing
ADD_SEALS = 1033


def sealed(write):
    fd = os.memfd_create("stage", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    write(fd)
    fcntl.fcntl(fd, ADD_SEALS, SEALS)
    return fd


class Child:
    def __init__(self, sock):
        self.socket, self.stage, self.reader = sock, None, None

    def answer(self, message, fd=None):
        """Lists go before the answer, in parts, where they are long."""
        for key in [k for k in message if isinstance(message[k], list)]:
            while len(json.dumps(message[key])) > MOST // 4:
                self.socket.sendmsg([json.dumps({"part": {key: message[key][:10]}}).encode()])
                message[key] = message[key][10:]
        text = json.dumps(message).encode()
        rights = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [fd]))] if fd is not None else []
        self.socket.sendmsg([text], rights)
        if fd is not None:
            os.close(fd)

    def run(self):
        while True:
            message = self.socket.recv(1 << 16)
            if not message:
                return
            asked = json.loads(message)
            if asked["do"] == "quit":
                return
            self.end_with_parent(True)
            try:
                made = getattr(self, "do_" + asked["do"])(asked)
                made = made if isinstance(made, tuple) else (made, None)
            except RecursionError:
                made = {"fault": {"text": "its prims lie in each other too deeply, or without end"}}, None
            except MemoryError:
                made = {"fault": {"text": "there is not enough memory to read it", "memory": True}}, None
            except UnicodeDecodeError:
                made = {"fault": {"text": "a text in it is not UTF-8: it is damaged"}}, None
            except Exception as e:
                said = getattr(e, "said", None)
                if not said:
                    import traceback
                    traceback.print_exc()
                    said = {"text": "the reader failed: %s: %s" % (type(e).__name__, str(e).strip()[:400])}
                made = {"fault": said}, None
            self.end_with_parent(False)
            self.answer(*made)

    def end_with_parent(self, ends):
        """While it works, the parent says nothing: what comes is its end, and ends the work, too."""
        fcntl.fcntl(self.socket, fcntl.F_SETOWN, os.getpid())
        flags = fcntl.fcntl(self.socket, fcntl.F_GETFL)
        fcntl.fcntl(self.socket, fcntl.F_SETFL, flags | os.O_ASYNC if ends else flags & ~os.O_ASYNC)

    def do_hello(self, asked):
        if asked["protocol"] != PROTOCOL:
            return {"fault": {"text": "the reader speaks protocol %d, the program %d: install both again" % (PROTOCOL, asked["protocol"])}}
        self.folders, self.everywhere = asked["folders"], asked["everywhere"]
        fence.limit_memory(asked["bytes"])
        version = fence.raise_fence(self.folders, SITE, self.everywhere)
        try:
            from pxr import Tf, Usd
        except ImportError as e:
            return {"missing": str(e)[:300]}
        try:
            import MaterialX
            mtlx = MaterialX.__version__
        except ImportError:
            mtlx = None
        return {"usd": list(Usd.GetVersion()), "python": "%d.%d.%d" % sys.version_info[:3], "mtlx": mtlx, "landlock": version}

    def do_open(self, asked):
        from alabaster_usd import opening
        self.stage, opened = opening.open_stage(asked, self.folders, self.everywhere)
        text = json.dumps(opened).encode()
        return {}, sealed(lambda fd: os.write(fd, text) == len(text) or opening.fail())

    def do_scene(self, asked):
        from alabaster_usd import opening, scene, values
        values.may_read = lambda file: self.everywhere or opening.is_within(file, self.folders)
        asked["may_write"] = lambda file: self.everywhere or opening.is_within(file, self.folders[:1])

        def read(sink, told):
            self.reader = scene.Reader(self.stage, sink, told, asked.get("time"), asked)
            return self.reader.run()

        sink, told, stands_beside = self.without_damage(read)
        self.told = set(told.kinds)
        return {"warnings": told.warnings(), "faults": told.faults}, sealed(lambda fd: sink.write(fd, stands_beside))

    def do_time(self, asked):
        """After a scene: the prims that differ from the last answer, and what was not told before."""
        sink, told, gone = self.without_damage(lambda sink, told: self.reader.advance(asked["time"], sink, told))
        new = [w for w in told.warnings() if w[0] not in self.told]
        self.told.update(told.kinds)
        return {"warnings": new, "faults": told.faults}, sealed(lambda fd: sink.write(fd, {"removed": gone}))

    def without_damage(self, read):
        """(sink, notes, what `read` of them gives). A value clip that is damaged ends the first value that is asked of it, and is passed over
        from then on: that is a fault, and all is read again."""
        from pxr import Tf
        from alabaster_usd import notes, opening, values
        damaged = []
        while True:
            sink, told = values.Archive(), notes.Notes()
            try:
                made = read(sink, told)
            except Tf.ErrorException as e:
                damage = opening.damage_of(e, self.stage, self.stage.GetRootLayer().realPath)
                if damage in damaged or len(damaged) == 50:
                    raise notes.Fault(**damage) from None
                damaged.append(damage)
                continue
            told.faults[:0] = damaged
            return sink, told, made


if __name__ == "__main__":
    Child(socket.socket(fileno=3)).run()
