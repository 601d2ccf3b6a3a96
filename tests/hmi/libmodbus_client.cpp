// libmodbus reads and writes every kind of address of examples/hmi. usage: libmodbus_client PORT
//
// WHY own packing: modbus_set_float_abcd() and its siblings of Debian 12 exchange the bytes of each register.
#include <modbus/modbus.h>

#include <bit>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace {

int failures = 0;

void check(const char* what, bool good) {
  std::printf("%s %s\n", good ? "ok  " : "FAIL", what);
  if (!good) ++failures;
}

/// True within a second: the program needs a cycle.
void expect(const char* what, const std::function<bool()>& holds) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  bool good = holds();
  while (!good && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    good = holds();
  }
  check(what, good);
}

/// High word first.
std::uint64_t joined(const std::vector<std::uint16_t>& words) {
  std::uint64_t value = 0;
  for (const std::uint16_t word : words) value = value << 16 | word;
  return value;
}
std::vector<std::uint16_t> split(std::uint64_t value, int count) {
  std::vector<std::uint16_t> words;
  for (int i = count - 1; i >= 0; --i) words.push_back(static_cast<std::uint16_t>(value >> (16 * i)));
  return words;
}

class Client {
 public:
  explicit Client(int port) : context_(modbus_new_tcp("127.0.0.1", port), modbus_free) {
    modbus_set_response_timeout(context_.get(), 3, 0);
  }
  [[nodiscard]] modbus_t* get() const { return context_.get(); }

  [[nodiscard]] std::vector<std::uint16_t> holding(int address, int count) const {
    std::vector<std::uint16_t> words(static_cast<std::size_t>(count));
    if (modbus_read_registers(get(), address, count, words.data()) != count) words.clear();
    return words;
  }
  [[nodiscard]] bool write(int address, const std::vector<std::uint16_t>& words) const {
    const int count = static_cast<int>(words.size());
    return modbus_write_registers(get(), address, count, words.data()) == count;
  }
  [[nodiscard]] bool coils_are(int address, const std::vector<std::uint8_t>& wanted) const {
    std::vector<std::uint8_t> bits(wanted.size());
    const int count = static_cast<int>(bits.size());
    return modbus_read_bits(get(), address, count, bits.data()) == count && bits == wanted;
  }

 private:
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
};

void bits(const Client& client) {
  check("start", modbus_write_bit(client.get(), 8192, 1) == 1);
  expect("the belt runs", [&] { return client.coils_are(0, {1, 1}); });
  const std::uint8_t stop[] = {0, 1};
  check("stop, two coils at once", modbus_write_bits(client.get(), 8192, 2, stop) == 2);
  expect("the belt stands", [&] { return client.coils_are(0, {0, 0}); });
  const std::uint8_t none[] = {0, 0};
  check("commands off", modbus_write_bits(client.get(), 8192, 2, none) == 2);
  bool seen[2] = {false, false};
  for (int i = 0; i < 150 && !(seen[0] && seen[1]); ++i) {
    std::uint8_t bit = 0;
    if (modbus_read_input_bits(client.get(), 0, 1, &bit) == 1) seen[bit != 0] = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  check("parts pass the light barrier", seen[0] && seen[1]);
}

void registers(const Client& client) {
  std::uint16_t word = 0;
  check("a constant as input register",
        modbus_read_input_registers(client.get(), 16384, 1, &word) == 1 && word == 1000);
  std::uint16_t level = 0;
  check("level", modbus_read_input_registers(client.get(), 0, 1, &level) == 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  check("the level moves", modbus_read_input_registers(client.get(), 0, 1, &word) == 1 && word != level);

  check("set speed", modbus_write_register(client.get(), 1024, 321) == 1);
  expect("speed follows", [&] { return client.holding(0, 1) == std::vector<std::uint16_t>{321}; });
  check("REAL", client.write(2048, split(std::bit_cast<std::uint32_t>(37.5f), 2)));
  expect("37.5 degrees are 99.5 Fahrenheit",
         [&] { return std::bit_cast<float>(static_cast<std::uint32_t>(joined(client.holding(2050, 2)))) == 99.5f; });
  check("DINT", client.write(2052, split(static_cast<std::uint32_t>(-2000), 2)));
  expect("length of the order", [&] { return static_cast<std::int32_t>(joined(client.holding(2054, 2))) == -500'000; });
  check("LREAL", client.write(4096, split(std::bit_cast<std::uint64_t>(0.125), 4)));
  expect("price of a MWh", [&] { return std::bit_cast<double>(joined(client.holding(4100, 4))) == 125.0; });
  check("recipe", client.write(16384, {5, 6, 7, 8}));
  expect("the recipe adds up", [&] { return client.holding(16391, 1) == std::vector<std::uint16_t>{26}; });
  check("mask write", modbus_mask_write_register(client.get(), 1024, 0xff00, 0x0002) != -1);
  expect("speed follows bit by bit", [&] { return client.holding(0, 1) == std::vector<std::uint16_t>{0x0102}; });
}

void refusals(const Client& client) {
  check("what may not be written is refused", modbus_write_register(client.get(), 2050, 1) == -1);
  std::uint16_t word = 0;
  errno = 0;
  check("an address outside the map is refused",
        modbus_read_registers(client.get(), 9000, 1, &word) == -1 && errno == EMBXILADD);
}

}  // namespace

int main(int argc, char** argv) {
  const Client client(argc > 1 ? std::atoi(argv[1]) : 502);
  if (modbus_connect(client.get()) != 0) {
    std::printf("FAIL connect: %s\n", modbus_strerror(errno));
    return 1;
  }
  bits(client);
  registers(client);
  refusals(client);
  modbus_close(client.get());
  return failures == 0 ? 0 : 1;
}
