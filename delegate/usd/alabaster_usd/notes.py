"""What a reader tells: faults, and one warning for each kind of thing that is not read, with a count and the first path."""


class Fault(Exception):
    """Bad input: the picture would lack something that the stage names."""

    def __init__(self, text, file="", prim="", line=0):
        super().__init__(text)
        self.said = {"text": text, "file": file, "prim": str(prim), "line": line}


MOST = 200  # faults


class Notes:
    def __init__(self):
        self.faults, self.kinds, self.vendors = [], {}, {}

    def fault(self, text, file="", prim="", line=0):
        if len(self.faults) < MOST:
            self.faults.append(Fault(text[:2000], file, prim, line).said)

    def tell(self, kind, path):
        """`kind` is the sentence, which is one for all prims that it holds of."""
        count, first = self.kinds.get(kind, (0, str(path)))
        self.kinds[kind] = (count + 1, first)

    def warnings(self):
        return [[kind, count, first] for kind, (count, first) in sorted(self.kinds.items())]
