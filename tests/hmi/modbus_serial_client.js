// modbus-serial reads and writes every kind of address of examples/hmi. usage: node modbus_serial_client.js PORT
const ModbusRTU = require('modbus-serial');

let failures = 0;
const check = (what, good, shown) => {
  if (!good) failures++;
  console.log(good ? 'ok  ' : 'FAIL', what, shown === undefined ? '' : shown);
};
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
// The value within a second: the program needs a cycle.
const expect = async (what, wanted, read) => {
  const deadline = Date.now() + 1000;
  let got = await read();
  while (got !== wanted && Date.now() < deadline) {
    await pause(20);
    got = await read();
  }
  check(what, got === wanted, got);
};

(async () => {
  const client = new ModbusRTU();
  await client.connectTCP('127.0.0.1', {port: Number(process.argv[2])});
  client.setID(1);
  client.setTimeout(3000);
  const coil = async (at) => (await client.readCoils(at, 1)).data[0];
  const word = async (at) => (await client.readHoldingRegisters(at, 1)).data[0];
  const bytes = async (at, count) => (await client.readHoldingRegisters(at, count)).buffer;

  await client.writeCoil(8192, true);
  await expect('the belt runs', true, () => coil(0));
  await client.writeCoils(8192, [false, true]);
  await expect('the belt stands', false, () => coil(0));
  await client.writeCoils(8192, [false, false]);
  const seen = new Set();
  for (let i = 0; i < 150 && seen.size < 2; i++) {
    seen.add((await client.readDiscreteInputs(0, 1)).data[0]);
    await pause(20);
  }
  check('parts pass the light barrier', seen.size === 2);

  check('a constant as input register', (await client.readInputRegisters(16384, 1)).data[0] === 1000);
  const level = (await client.readInputRegisters(0, 1)).data[0];
  await pause(1200);
  check('the level moves', (await client.readInputRegisters(0, 1)).data[0] !== level);

  await client.writeRegister(1024, 777);
  await expect('speed follows', 777, () => word(0));
  const real = Buffer.alloc(4);
  real.writeFloatBE(20);
  await client.writeRegisters(2048, real);
  await expect('REAL: 20 degrees in Fahrenheit', 68, async () => (await bytes(2050, 2)).readFloatBE(0));
  const dint = Buffer.alloc(4);
  dint.writeInt32BE(-40000);
  await client.writeRegisters(2052, dint);
  await expect('DINT: length of the order', -10000000, async () => (await bytes(2054, 2)).readInt32BE(0));
  const lreal = Buffer.alloc(8);
  lreal.writeDoubleBE(0.5);
  await client.writeRegisters(4096, lreal);
  await expect('LREAL: price of a MWh', 500, async () => (await bytes(4100, 4)).readDoubleBE(0));
  await client.writeRegisters(16384, [100, 200, 300, 400]);
  await expect('the recipe adds up', 1000, () => word(16391));

  const together = await Promise.all([...Array(20).keys()].map((i) => client.readHoldingRegisters(16384 + (i % 4), 1)));
  check('20 requests without waiting', together.every((r, i) => r.data[0] === 100 * (1 + (i % 4))));
  const code = (request) => request.then(() => 0, (error) => error.modbusCode);
  check('what may not be written is refused', await code(client.writeRegister(2050, 1)) > 0);
  check('an address outside the map is refused', await code(client.readHoldingRegisters(9000, 1)) === 2);
  client.close(() => process.exit(failures ? 1 : 0));
})().catch((error) => {
  console.log('FAIL', error);
  process.exit(1);
});
