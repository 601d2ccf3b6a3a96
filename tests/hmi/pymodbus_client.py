#!/usr/bin/python3
"""pymodbus reads and writes every kind of address of examples/hmi. usage: pymodbus_client.py PORT|LINE"""
import sys
import time

try:
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient
    from pymodbus.constants import Endian
    from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder
    from pymodbus.register_read_message import ReadWriteMultipleRegistersRequest
    from pymodbus.register_write_message import MaskWriteRegisterRequest
except ImportError as missing:
    print(f"skipped: python3-pymodbus is not complete: {missing}")
    sys.exit(77)

if sys.argv[1].startswith("/"):
    client = ModbusSerialClient(sys.argv[1], baudrate=115200, parity="N", timeout=3)
else:
    client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]), timeout=3)
failures = []


def check(what, good, shown=""):
    print("ok  " if good else "FAIL", what, shown)
    if not good:
        failures.append(what)


def expect(what, wanted, read):
    """The value within a second: the program needs a cycle."""
    deadline = time.monotonic() + 1
    while (got := read()) != wanted and time.monotonic() < deadline:
        time.sleep(0.02)
    check(what, got == wanted, got)


def good(response):
    return not response.isError()


def coils(address, count):
    return client.read_coils(address, count, slave=1).bits[:count]


def words(address, count=1):
    return client.read_holding_registers(address, count, slave=1).registers


def decoder(address, count):
    return BinaryPayloadDecoder.fromRegisters(words(address, count), byteorder=Endian.Big, wordorder=Endian.Big)


def write(address, add):
    builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=Endian.Big)
    add(builder)
    return good(client.write_registers(address, builder.to_registers(), slave=1))


check("connect", client.connect())

check("FC5 start", good(client.write_coil(8192, True, slave=1)))
expect("the belt runs", [True, True], lambda: coils(0, 2))
check("FC15 stop", good(client.write_coils(8192, [False, True], slave=1)))
expect("the belt stands", [False, False], lambda: coils(0, 2))
client.write_coils(8192, [False, False], slave=1)
check("FC1 2000 coils", len(client.read_coils(0, 2000, slave=1).bits) == 2000)

seen = set()
deadline = time.monotonic() + 3
while len(seen) < 2 and time.monotonic() < deadline:
    seen.add(client.read_discrete_inputs(0, 1, slave=1).bits[0])
    time.sleep(0.02)
check("FC2 parts pass", seen == {False, True}, seen)

check("FC4 a constant", client.read_input_registers(16384, 1, slave=1).registers == [1000])
level = client.read_input_registers(0, 1, slave=1).registers[0]
time.sleep(1.2)
check("FC4 the level moves", client.read_input_registers(0, 1, slave=1).registers[0] != level)
scans = words(1025)[0]
time.sleep(0.3)
check("FC3 scans count", (words(1025)[0] - scans) % 65536 in range(15, 200))
check("FC3 125 registers", len(words(1024, 125)) == 125)

check("FC6 set-point", good(client.write_register(1024, 640, slave=1)))
expect("speed follows", [640], lambda: words(0))
check("FC22 mask write", good(client.execute(MaskWriteRegisterRequest(1024, 0xFF00, 0x0001, unit=1))))
expect("speed follows bit by bit", [0x0201], lambda: words(0))
check("FC16 REAL", write(2048, lambda b: b.add_32bit_float(-40.0)))
expect("-40 degrees in Fahrenheit", -40.0, lambda: decoder(2050, 2).decode_32bit_float())
check("FC16 DINT", write(2052, lambda b: b.add_32bit_int(-123456)))
expect("length of a negative order", -30864000, lambda: decoder(2054, 2).decode_32bit_int())
check("FC16 LREAL", write(4096, lambda b: b.add_64bit_float(0.3125)))
expect("price of a MWh", 312.5, lambda: decoder(4100, 4).decode_64bit_float())
response = client.execute(
    ReadWriteMultipleRegistersRequest(read_address=16384, read_count=4, write_address=16384, write_registers=[10, 20, 30, 40], unit=1))
check("FC23", good(response) and len(response.registers) == 4)
expect("the recipe adds up", [100], lambda: words(16391))

response = client.write_register(2050, 1, slave=1)
check("what may not be written is refused", response.isError(), response)
response = client.read_holding_registers(9000, 1, slave=1)
check("an address outside the map is refused", response.isError() and response.exception_code == 2, response)
client.close()
sys.exit(1 if failures else 0)
