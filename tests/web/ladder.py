"""A project of one large ladder, whose names are markup where names may be anything."""

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="x" productName="x" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="ladder"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd><ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="Logic" pouType="program"><interface><localVars>{variables}</localVars></interface><body><LD>
"""
TAIL = """</LD></body></pou></pous></types>
<instances><configurations><configuration name="c"><resource name="r"><task name="cyclic" interval="T#20ms" priority="0"><pouInstance name="main" typeName="Logic"/></task></resource></configuration></configurations></instances>
</project>
"""


def write(path, rungs):
    """Rung n: contacts A and Bn, coil Cn. A blinks: it is the negation of itself."""
    bits = ["A"] + [f"B{n % 100}" for n in range(min(rungs, 100))] + [f"C{n}" for n in range(rungs)]
    with open(path, "w") as file:
        file.write(HEAD.format(variables="".join(f'<variable name="{b}"><type><BOOL/></type></variable>' for b in bits)))
        ident = 0

        def element(kind, source, variable="", extra=""):
            nonlocal ident
            ident += 1
            incoming = "" if source is None else f'<connectionPointIn><connection refLocalId="{source}"/></connectionPointIn>'
            outgoing = "" if kind == "rightPowerRail" else '<connectionPointOut formalParameter=""/>'
            name = f"<variable>{variable}</variable>" if variable else ""
            file.write(f'<{kind} localId="{ident}"{extra}><position x="0" y="0"/>{incoming}{outgoing}{name}</{kind}>\n')
            return ident

        def rung(*contacts, coil):
            at = element("leftPowerRail", None)
            for name, negated in contacts:
                at = element("contact", at, name, ' negated="true"' if negated else "")
            at = element("coil", at, coil)
            element("rightPowerRail", at)

        rung(("A", True), coil="A")
        for n in range(rungs):
            rung(("A", False), (f"B{n % 100}", True), coil=f"C{n}")
        file.write(TAIL)
    return path
