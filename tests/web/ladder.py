"""Projects of one ladder: a large one, and one whose inputs and rungs are random."""

import random

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="x" productName="x" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="ladder"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd><ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="Logic" pouType="program"><interface><localVars>{variables}</localVars></interface><body><LD>
"""
TAIL = """</LD></body></pou></pous></types>
<instances><configurations><configuration name="c">{globals}<resource name="r"><task name="cyclic" interval="T#20ms" priority="0"><pouInstance name="main" typeName="Logic"/></task></resource></configuration></configurations></instances>
</project>
"""


class Drawing:
    """A ladder that is being written to a file."""

    def __init__(self, file):
        self.file = file
        self.ident = 0

    def element(self, kind, sources, variable="", extra=""):
        """`sources`: what is connected to it. The number of the element."""
        self.ident += 1
        inputs = "".join(f'<connection refLocalId="{source}"/>' for source in sources)
        incoming = f"<connectionPointIn>{inputs}</connectionPointIn>" if sources else ""
        outgoing = "" if kind == "rightPowerRail" else '<connectionPointOut formalParameter=""/>'
        name = f"<variable>{variable}</variable>" if variable else ""
        self.file.write(f'<{kind} localId="{self.ident}"{extra}><position x="0" y="0"/>{incoming}{outgoing}{name}</{kind}>\n')
        return self.ident

    def contact(self, sources, variable, negated=False):
        return self.element("contact", sources, variable, ' negated="true"' if negated else "")

    def rung(self, *contacts, coil):
        at = self.element("leftPowerRail", [])
        for name, negated in contacts:
            at = self.contact([at], name, negated)
        self.element("rightPowerRail", [self.element("coil", [at], coil)])


def variables(names, address=lambda name: ""):
    return "".join(f'<variable name="{name}"{address(name)}><type><BOOL/></type></variable>' for name in names)


def write(path, rungs):
    """Rung n: contacts A and Bn, coil Cn. A blinks: it is the negation of itself."""
    bits = ["A"] + [f"B{n % 100}" for n in range(min(rungs, 100))] + [f"C{n}" for n in range(rungs)]
    with open(path, "w") as file:
        file.write(HEAD.format(variables=variables(bits)))
        drawing = Drawing(file)
        drawing.rung(("A", True), coil="A")
        for n in range(rungs):
            drawing.rung(("A", False), (f"B{n % 100}", True), coil=f"C{n}")
        file.write(TAIL.format(globals=""))
    return path


PULSES = """</LD></body></pou><pou name="Pulses" pouType="program"><interface><localVars><variable name="n"><type><INT/></type></variable>
<variable name="last"><type><INT/></type></variable></localVars><externalVars><variable name="P"><type>{array}</type></variable></externalVars></interface>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">P[last] := FALSE; n := (n + 1) MOD 1000; IF n MOD 10 = 0 THEN last := n / 10; P[last] := TRUE; END_IF;</xhtml></ST></body></pou></pous></types>
<instances><configurations><configuration name="c"><globalVars><variable name="P"><type>{array}</type></variable></globalVars><resource name="r"><task name="fast" interval="T#1ms" priority="0"><pouInstance name="pulses" typeName="Pulses"/><pouInstance name="main" typeName="Logic"/></task></resource></configuration></configurations></instances>
</project>
"""


def write_pulses(path):
    """A hundred coils, of which every 10 ms another one is TRUE for one scan of 1 ms: each once a second."""
    array = '<array><dimension lower="0" upper="99"/><baseType><BOOL/></baseType></array>'
    with open(path, "w") as file:
        head = HEAD.replace("<localVars>", f'<externalVars><variable name="P"><type>{array}</type></variable></externalVars><localVars>')
        file.write(head.format(variables=variables(f"C{n}" for n in range(100))))
        drawing = Drawing(file)
        for n in range(100):
            drawing.rung((f"P[{n}]", False), coil=f"C{n}")
        file.write(PULSES.format(array=array))
    return path


def write_random(path, stimulus, rungs, seconds, seed):
    """Rungs of contacts in series and in parallel; the inputs change every 40 ms, for so many seconds."""
    chance = random.Random(seed)
    inputs = [f"In{n}" for n in range(8)]
    coils = [f"C{n}" for n in range(rungs)]
    with open(path, "w") as file:
        outside = "<externalVars>" + variables(inputs) + "</externalVars><localVars>"
        file.write(HEAD.replace("<localVars>", outside).format(variables=variables(coils)))
        drawing = Drawing(file)
        for n in range(rungs):
            rail = drawing.element("leftPowerRail", [])
            ends = []
            for _ in range(chance.randint(1, 3)):
                at = rail
                for _ in range(chance.randint(1, 3)):
                    at = drawing.contact([at], chance.choice(inputs + coils), chance.random() < 0.4)
                ends.append(at)
            # Set and reset coils come in pairs, so that neither stays for ever.
            storage = ("", ' storage="set"', ' storage="reset"')[n % 3]
            coil = drawing.element("coil", ends, coils[n - 1] if n % 3 == 2 else coils[n], storage)
            drawing.element("rightPowerRail", [coil])
        inside = variables(inputs, lambda name: f' address="%IX0.{name[2:]}"')
        file.write(TAIL.format(globals=f"<globalVars>{inside}</globalVars>"))
    with open(stimulus, "w") as file:
        file.write(",".join(["time_ms", *inputs]) + "\n")
        for time_ms in range(0, 1000 * seconds, 40):
            file.write(",".join([str(time_ms), *(str(chance.randint(0, 1)) for _ in inputs)]) + "\n")
