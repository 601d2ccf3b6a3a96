// Settings of lines, times, opening.
#include "io-drivers/modbus-rtu/line.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>

namespace plc::modbus_rtu {
namespace {

TEST(Line, SettingsAreReadAsPeopleWriteThem) {
  EXPECT_EQ(parse_line("19200 8E1"), LineSettings{});
  EXPECT_EQ(parse_line("9600 8n2"), (LineSettings{9600, 8, Parity::kNone, 2}));
  EXPECT_EQ(parse_line("115200 8O1 "), (LineSettings{115200, 8, Parity::kOdd, 1}));
  for (const char* text :
       {"", "9600", "9600 7E1", "9600 8X1", "9600 8E3", "9601 8E1", "x 8E1", "9600x 8E1", "-9600 8E1"}) {
    EXPECT_FALSE(parse_line(text).has_value()) << text;
  }
}

TEST(Line, TimesFollowTheSpeed) {
  EXPECT_EQ(silence_ns({9600, 8, Parity::kEven, 1}), 4'010'416);
  EXPECT_EQ(silence_ns({19200, 8, Parity::kEven, 1}), 2'005'208);
  EXPECT_EQ(silence_ns({115200, 8, Parity::kEven, 1}), 1'750'000);
  EXPECT_EQ(characters_ns({1200, 8, Parity::kEven, 1}, 12), 110'000'000);
}

TEST(Line, IsOpenedAsTheSettingsSay) {
  int master = -1, slave = -1;
  char name[128] = {};
  ASSERT_EQ(::openpty(&master, &slave, name, nullptr, nullptr), 0);
  const int fd = open_line(name, {9600, 8, Parity::kOdd, 2});
  ASSERT_GE(fd, 0);
  termios line = {};
  ASSERT_EQ(::tcgetattr(fd, &line), 0);
  EXPECT_EQ(::cfgetispeed(&line), static_cast<speed_t>(B9600));
  EXPECT_EQ(line.c_cflag & (CSTOPB | CRTSCTS), static_cast<tcflag_t>(CSTOPB));
  EXPECT_EQ(line.c_lflag & (ICANON | ECHO | ISIG), 0u);
  EXPECT_EQ(line.c_oflag & OPOST, 0u);
  ::close(fd);
  const int again = open_line(name, {9600, 8, Parity::kOdd, 2});
  EXPECT_GE(again, 0) << "with what is set already";
  ::close(again);
  ::close(master);
  ::close(slave);
  EXPECT_EQ(open_line("/dev/no-such-line", {}), -ENOENT);
  EXPECT_EQ(open_line("/dev/null", {}), -ENOTTY);
}

}  // namespace
}  // namespace plc::modbus_rtu
