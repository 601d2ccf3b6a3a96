"""A project whose texts are markup, with much of everything."""

MARKUP = "<img src=x onerror=alert(1)><script>alert(2)$27</script>"


def write(folder):
    """The path of the project."""
    path = f"{folder}/<img src=x onerror=alert(3)> &amp; plant.st"
    with open(path, "w") as file:
        file.write(f"""TYPE Answer : ({'A' * 1000}, No); END_TYPE
TYPE Inner : STRUCT Deep : ARRAY [1..3] OF INT; Text : STRING[80]; END_STRUCT END_TYPE
TYPE Outer : STRUCT {'V' * 1000} : INT; In : Inner; END_STRUCT END_TYPE
VAR_GLOBAL
  Markup : STRING[200] := '{MARKUP}';
  Long : STRING[32000];
  Longs : ARRAY [0..319] OF STRING[32000];
  Many : ARRAY [0..99999] OF DINT;
  Nested : Outer;
  Choice : Answer;
  Wait : TIME := T#1m30s500ms;
  Day : DATE := D#2024-02-29;
  Large : LINT := -9007199254740993;
  Bits : WORD := 16#00FF;
  Small : REAL := 0.1;
  Count : DINT;
  Push AT %IX0.0 : BOOL;
  Lamp AT %QX0.0 : BOOL;
END_VAR
PROGRAM Main
VAR_EXTERNAL Long : STRING[32000]; Count : DINT; Push, Lamp : BOOL; END_VAR
VAR i : INT; Local : INT; END_VAR
  Count := Count + 1;
  Lamp := Push;
  IF Count < 7000 THEN Long := CONCAT(Long, '<b>x'); END_IF
END_PROGRAM
CONFIGURATION c
  RESOURCE r ON PLC
    TASK t(INTERVAL := T#20ms, PRIORITY := 1);
    PROGRAM main WITH t : Main;
  END_RESOURCE
END_CONFIGURATION
""")
    return path
