// Every kind of wrong plc.toml: which problems, in which line and column, in file order.
#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "io-drivers/config/configuration.h"
#include "io-drivers/machine/driver_types.h"

namespace plc::io {
namespace {

struct Wrong {
  const char* name;
  const char* text;
  const char* problems;  ///< "line:column code", one a line
};
std::ostream& operator<<(std::ostream& out, const Wrong& wrong) { return out << wrong.name; }

constexpr Wrong kWrong[] = {
    // Not TOML.
    {"AddressWithoutQuotes", "[inputs]\n%IX0.0 = { driver = \"a\" }\n", "2:1 P7301"},
    {"TextWithoutQuotes", "[drivers.panel]\nkind = gpio\n", "2:8 P7301"},
    {"DurationWithoutQuotes", "[guardian]\nhang_timeout = 500ms\n", "2:19 P7301"},
    {"InlineTableOverTwoLines", "[inputs]\n\"%IX0.0\" = { driver = \"a\",\n channel = 1 }\n", "2:27 P7301"},
    {"KeyTwice", "[modbus]\nread_only = true\nread_only = true\n", "3:13 P7301"},
    {"TableTwice", "[modbus]\n[guardian]\n[modbus]\n", "3:1 P7301"},
    {"OpenBracket", "[modbus\n", "1:8 P7301"},
    {"OpenText", "[modbus]\nlisten = \"off\n", "2:14 P7301"},
    {"NoUtf8", "[modbus]\n# \xff\xfe\n", "2:2 P7301"},
    {"NumberOfMoreThan64Bits", "[modbus]\nmax_clients = 99999999999999999999\n", "2:35 P7301"},
    {"XmlInstead", "<?xml version=\"1.0\"?>\n<project/>\n", "1:1 P7301"},
    {"NotAsciiOutsideOfQuotes", "[drivers.k\xd2\x93]\n", "1:11 P7301"},
    {"NotAsciiAsAValue", "[modbus]\nlisten = \xc2\xa7\n", "2:10 P7301"},
    {"ControlCharacterInAHeader", "[modbus\x01]\n", "1:8 P7301"},
    {"QuoteInsideAWord", "[modbus]\nunit_id = 5\"\n", "2:12 P7301"},
    {"QuoteInsideAName", "[inputs]\nArr[\"1\"] = {}\n", "2:5 P7301"},
    {"NotAsciiAfterAJoinedLine", "[drivers.a]\nkind = \"\"\"\\\n \xc2\xa7\"\"\"\n", "3:2 P7301"},
    {"OnlyTheFirstSyntaxError", "a = \nb = \n", "1:5 P7301"},
    // Unknown names.
    {"UnknownTable", "[modbuss]\n", "1:2 P7303"},
    {"UnknownTableOfNestedHeader", "[driver.panel]\nkind = \"gpio\"\n", "1:2 P7303"},
    {"KeyOutsideOfTables", "listen = \"off\"\n", "1:1 P7303"},
    {"UnknownKeyOfModbus", "[modbus]\nlisen = \"off\"\n", "2:1 P7303"},
    {"UnknownKeyOfDriver", "[drivers.a]\nkind = \"simulated\"\nspeed = 3\n", "3:1 P7303"},
    {"UnknownKeyOfInput", "[drivers.a]\nkind = \"simulated\"\n[inputs]\nX = { driver = \"a\", chanel = 1 }\n",
     "4:21 P7303"},
    {"UnknownKeyOfRange", "[[modbus.range]]\ntable = \"coils\"\nbegin = 4\n", "3:1 P7303"},
    {"UnknownKeyOfSerial", "[modbus.serial]\npath = \"/dev/ttyS0\"\nbaud = 9600\n", "3:1 P7303"},
    {"UnknownKeyOfScheduler", "[scheduler]\nprocessor = 1\n", "2:1 P7303"},
    {"UnknownKeyOfTask", "[tasks.Fast]\ninterval = \"5ms\"\n", "2:1 P7303"},
    {"UnknownKeyOfGuardian", "[guardian]\ntimeout = \"1s\"\n", "2:1 P7303"},
    {"UnknownKeyOfRetain", "[retain]\nfolder = \"x\"\n", "2:1 P7303"},
    {"KeysAreLowerCase", "[guardian]\nEnabled = true\n", "2:1 P7303"},
    {"PathWithoutQuotes", "[drivers.a]\nkind = \"simulated\"\n[inputs]\nMain.Start = { driver = \"a\" }\n",
     "4:1 P7303"},
    // Wrong types.
    {"TableIsANumber", "guardian = 5\n", "1:1 P7304"},
    {"TableIsAList", "[[inputs]]\n", "1:3 P7304"},
    {"StateIsANumber", "[retain]\nstate = 5\n", "2:9 P7304"},
    {"TaskIsANumber", "[tasks]\nFast = 5\n", "2:1 P7304"},
    {"WatchdogIsANumber", "[tasks.Fast]\nwatchdog = 5\n", "2:12 P7304"},
    {"DriverIsAText", "[drivers]\npanel = \"gpiochip0\"\n", "2:1 P7304"},
    {"InputIsANumber", "[inputs]\n\"%IX0.0\" = 17\n", "2:12 P7304"},
    {"FlagIsAText", "[modbus]\nread_only = \"yes\"\n", "2:13 P7304"},
    {"FlagIsANumber", "[modbus]\nread_only = 1\n", "2:13 P7304"},
    {"NumberIsAText", "[modbus]\nmax_clients = \"8\"\n", "2:15 P7304"},
    {"NumberHasAFraction", "[modbus]\nmax_clients = 8.0\n", "2:15 P7304"},
    {"DurationIsANumber", "[guardian]\nhang_timeout = 500\n", "2:16 P7304"},
    {"ListenIsANumber", "[modbus]\nlisten = 502\n", "2:10 P7304"},
    {"ListIsAText", "[modbus]\nwritable = \"Main.*\"\n", "2:12 P7304"},
    {"ListHoldsANumber", "[modbus]\nwritable = [\"a\", 5]\n", "2:18 P7304"},
    {"TextIsADate", "[drivers.a]\nkind = \"simulated\"\ntask = 2024-01-01\n", "3:8 P7304"},
    {"SerialIsAText", "[modbus]\nserial = \"/dev/ttyS0\"\n", "2:10 P7304"},
    {"SerialTwice", "[[modbus.serial]]\npath = \"/dev/ttyS0\"\n", "1:1 P7304"},
    {"RangeWithOneBracket", "[modbus.range]\ntable = \"coils\"\n", "1:1 P7304"},
    {"SafeIsAList", "[drivers.a]\nkind = \"simulated\"\n[outputs]\nX = { driver = \"a\", safe = [1] }\n", "4:28 P7304"},
    {"ChannelIsAFlag", "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = true }\n",
     "5:31 P7304"},
    // Values.
    {"ListenWithoutAddress", "[modbus]\nlisten = \":502\"\n", "2:10 P7305"},
    {"ListenWithoutPort", "[modbus]\nlisten = \"127.0.0.1\"\n", "2:10 P7305"},
    {"ListenOnAName", "[modbus]\nlisten = \"localhost:502\"\n", "2:10 P7305"},
    {"ListenOnSixWithoutBrackets", "[modbus]\nlisten = \"::1:502\"\n", "2:10 P7305"},
    {"ListenOnPort65536", "[modbus]\nlisten = \"127.0.0.1:65536\"\n", "2:10 P7305"},
    {"ListenOnANegativePort", "[modbus]\nlisten = \"127.0.0.1:-1\"\n", "2:10 P7305"},
    {"ListenWithAZeroByte", "[modbus]\nlisten = \"127.0.0.1\\u0000:502\"\n", "2:10 P7305"},
    {"WordOrderOfNoKind", "[modbus]\nword_order = \"BIG\"\n", "2:14 P7305"},
    {"WordOrderInLowerCase", "[modbus]\nword_order = \"abcd\"\n", "2:14 P7305"},
    {"PrioritiesOfNoKind", "[scheduler]\npriorities = \"rms\"\n", "2:14 P7305"},
    {"PriorityNegative", "[tasks.Fast]\npriority = -1\n", "2:12 P7305"},
    {"ProcessorTooLarge", "[scheduler]\ncpu = 1024\n", "2:7 P7305"},
    {"DeadlineOfNothing", "[tasks.Fast]\ndeadline = \"0s\"\n", "2:12 P7305"},
    {"OverrunOfNoKind", "[tasks.Fast]\noverrun = \"stop\"\n", "2:11 P7305"},
    {"PolicyOfNoKind", "[tasks.Fast]\non_fault = \"safe\"\n", "2:12 P7305"},
    {"UnitOfALineTooLarge", "[modbus.serial]\npath = \"/dev/ttyS0\"\nunit = 248\n", "3:8 P7305"},
    {"SettingsOfALine", "[modbus.serial]\npath = \"/dev/ttyS0\"\nline = \"9600\"\n", "3:8 P7305"},
    {"NoPathOfALine", "[modbus.serial]\npath = \"COM3\"\n", "2:8 P7305"},
    {"UnitTooLarge", "[modbus]\nunit_id = 256\n", "2:11 P7305"},
    {"NoClients", "[modbus]\nmax_clients = 0\n", "2:15 P7305"},
    {"DurationWithoutUnit", "[guardian]\nhang_timeout = \"500\"\n", "2:16 P7305"},
    {"DurationOfWords", "[guardian]\nhang_timeout = \"soon\"\n", "2:16 P7305"},
    {"DurationTooLong", "[guardian]\nhang_timeout = \"2h\"\n", "2:16 P7305"},
    {"DurationTooShort", "[drivers.a]\nkind = \"simulated\"\nretry = \"0s\"\n", "3:9 P7305"},
    {"DurationNegative", "[guardian]\nhang_timeout = \"-1s\"\n", "2:16 P7305"},
    {"KindOfNoKind", "[drivers.a]\nkind = \"gpoi\"\n", "2:8 P7305"},
    {"BiasOfNoKind",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = 1, bias = \"up\" }\n",
     "5:41 P7305"},
    {"ChannelNegative", "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = -1 }\n",
     "5:31 P7305"},
    {"ChannelEmpty", "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = \"\" }\n",
     "5:31 P7305"},
    {"ChipEmpty", "[drivers.a]\nkind = \"gpio\"\nchip = \" \"\n", "3:8 P7305"},
    {"ChipWithAZeroByte", "[drivers.a]\nkind = \"gpio\"\nchip = \"gpio\\u0000chip0\"\n", "3:8 P7305"},
    {"NameOfDriver", "[drivers.\"my panel\"]\nkind = \"simulated\"\n", "1:10 P7305"},
    {"NameOfVariableEmpty", "[drivers.a]\nkind = \"simulated\"\n[inputs]\n\" \" = { driver = \"a\" }\n", "4:1 P7305"},
    {"EmptyPattern", "[modbus]\nexported = [\"\"]\n", "2:13 P7305"},
    {"RangeBeyond65535", "[[modbus.range]]\ntable = \"coils\"\nlast = 65536\n", "3:8 P7305"},
    {"UnknownModbusTable", "[[modbus.range]]\ntable = \"coil\"\n", "2:9 P7305"},
    {"LatchOfAnUnknownTable", "[[modbus.range]]\ntable = \"coil\"\nlatch = true\nword_order = \"CDAB\"\n", "2:9 P7305"},
    // Missing.
    {"NoKind", "[drivers.a]\n", "1:10 P7306"},
    {"NoChip", "[drivers.a]\nkind = \"gpio\"\n", "1:10 P7306"},
    {"NoDriver", "[inputs]\n\"%IX0.0\" = { channel = 17 }\n", "2:1 P7306"},
    {"NoChannel", "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\" }\n", "5:1 P7306"},
    {"NoPath", "[modbus.serial]\nunit = 3\n", "1:1 P7306"},
    {"NoTableOfRange", "[[modbus.range]]\nfirst = 1\n", "1:1 P7306"},
    {"EmptyInput", "[inputs]\n\"%IX0.0\" = {}\n", "2:1 P7306"},
    // In the wrong place.
    {"ChipOfSimulated", "[drivers.a]\nkind = \"simulated\"\nchip = \"c\"\n", "3:1 P7307"},
    {"StimulusOfGpio", "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\nstimulus = \"in.csv\"\n", "4:1 P7307"},
    {"BiasOfSimulated", "[drivers.a]\nkind = \"simulated\"\n[inputs]\nX = { driver = \"a\", bias = \"pull-up\" }\n",
     "4:21 P7307"},
    {"SafeOfAnInput", "[drivers.a]\nkind = \"simulated\"\n[inputs]\nX = { driver = \"a\", safe = false }\n",
     "4:21 P7307"},
    {"LatchOfAnOutput",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[outputs]\nX = { driver = \"a\", channel = 1, latch = \"rising\" }\n",
     "5:34 P7307"},
    {"DriveOfAnInput",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = 1, drive = \"push-pull\" "
     "}\n",
     "5:34 P7307"},
    {"WordOrderOfCoils", "[[modbus.range]]\ntable = \"coils\"\nword_order = \"CDAB\"\n", "3:14 P7307"},
    {"LatchOfRegisters", "[[modbus.range]]\ntable = \"holding-registers\"\nlatch = true\n", "3:9 P7307"},
    // One another.
    {"UnknownDriver", "[inputs]\nX = { driver = \"panel\", channel = 1 }\n", "2:16 P7308"},
    {"DriversAreComparedLetterByLetter",
     "[drivers.panel]\nkind = \"simulated\"\n[inputs]\nX = { driver = \"Panel\" }\n", "4:16 P7308"},
    {"VariableTwiceInOtherCase",
     "[drivers.a]\nkind = \"simulated\"\n[inputs]\n\"%IX0.0\" = { driver = \"a\" }\n\"%ix0.0\" = { driver = \"a\" }\n",
     "5:1 P7309"},
    {"VariableAsInputAndOutput",
     "[drivers.a]\nkind = \"simulated\"\n[outputs]\nX = { driver = \"a\" }\n[inputs]\nx = { driver = \"a\" }\n",
     "6:1 P7309"},
    {"ChannelTwice",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = 1 }\n"
     "Y = { driver = \"a\", channel = \"01\" }\n",
     "6:31 P7310"},
    {"ChannelAsInputAndOutput",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n[inputs]\nX = { driver = \"a\", channel = 1 }\n[outputs]\n"
     "Y = { driver = \"a\", channel = 1 }\n",
     "7:31 P7310"},
    {"ChannelOfOneChipTwice",
     "[drivers.a]\nkind = \"gpio\"\nchip = \"gpiochip0\"\n[drivers.b]\nkind = \"gpio\"\nchip = \"/dev/gpiochip0\"\n"
     "[inputs]\nX = { driver = \"a\", channel = 1 }\nY = { driver = \"b\", channel = 1 }\n",
     "9:31 P7310"},
    {"RangeBackwards", "[[modbus.range]]\ntable = \"coils\"\nfirst = 100\nlast = 10\n", "4:8 P7311"},
    {"WritableInputRegisters", "[[modbus.range]]\ntable = \"input-registers\"\nwritable = true\n", "3:12 P7311"},
    {"LatchOfAPolledDriver",
     "[inputs]\nX = { driver = \"a\", channel = 1, latch = \"rising\" }\n[drivers.a]\nkind = \"gpio\"\nchip = \"c\"\n"
     "poll = \"5ms\"\n",
     "2:42 P7311"},
    {"MoreClientsOfOneThanOfAll", "[modbus]\nmax_clients = 4\nmax_clients_per_address = 5\n", "3:27 P7311"},
    {"ExceptionForNoUnit", "[modbus]\nunit_exception = true\n", "2:18 P7311"},
    // Several at once, from top to bottom, whatever the order of TOML's tables.
    {"AllProblemsInOneRun",
     "[zones]\n[outputs]\nX = { driver = \"b\", safe = [] }\n[modbus]\nlisten = \"here\"\nread_only = 0\n"
     "[drivers.a]\nkind = \"gpio\"\nretry = 1\n[guardian]\nhang_timeout = \"\"\n",
     "1:2 P7303\n3:16 P7308\n3:28 P7304\n5:10 P7305\n6:13 P7304\n7:10 P7306\n9:9 P7304\n11:16 P7305"},
};

class WrongConfiguration : public testing::TestWithParam<Wrong> {};

TEST_P(WrongConfiguration, IsReportedAtItsPlace) {
  core::Diagnostics diagnostics;
  diagnostics.add_file("project.xml");
  EXPECT_FALSE(read_configuration(GetParam().text, "plc.toml", driver_types(), diagnostics).has_value());
  std::string found;
  for (const core::Diagnostic& d : diagnostics.all()) {
    found += (found.empty() ? "" : "\n") + std::to_string(d.at.line) + ':' + std::to_string(d.at.column) + ' ' +
             std::string(core::info(d.code).name);
    EXPECT_EQ(diagnostics.file_name(d.at.file), "plc.toml");
    EXPECT_FALSE(d.message.empty());
  }
  EXPECT_EQ(found, GetParam().problems) << [&] {
    std::string all;
    for (const core::Diagnostic& d : diagnostics.all()) all += diagnostics.render_one(d) + '\n';
    return all;
  }();
}

INSTANTIATE_TEST_SUITE_P(Files, WrongConfiguration, testing::ValuesIn(kWrong),
                         [](const auto& row) { return std::string(row.param.name); });

/// The first problem of a text, rendered.
std::string first_problem(std::string_view text) {
  core::Diagnostics diagnostics;
  read_configuration(text, "plc.toml", driver_types(), diagnostics);
  return diagnostics.all().empty() ? "" : diagnostics.render_one(diagnostics.all().front());
}

TEST(ConfigurationHelp, SaysHowToMendIt) {
  EXPECT_EQ(first_problem("[guardian]\nhang_timout = \"1s\"\n"),
            "plc.toml:2:1: error P7303: [guardian] has no key \"hang_timout\"\n  help: did you mean \"hang_timeout\"?");
  EXPECT_EQ(first_problem("[driver.panel]\nkind = \"gpio\"\n"),
            "plc.toml:1:2: error P7303: no table \"driver\" in plc.toml\n  help: did you mean \"drivers\"?");
  EXPECT_EQ(first_problem("hang_timeout = \"1s\"\n"),
            "plc.toml:1:1: error P7303: no table \"hang_timeout\" in plc.toml\n"
            "  help: \"hang_timeout\" belongs to [guardian]");
  EXPECT_EQ(first_problem("[drivers.panel]\nkind = \"simulated\"\n[inputs]\nX = { driver = \"pannel\" }\n"),
            "plc.toml:4:16: error P7308: no driver \"pannel\"\n  help: did you mean \"panel\"?");
  EXPECT_EQ(first_problem("[inputs]\n%IX0.0 = { driver = \"a\" }\n").substr(0, 27), "plc.toml:2:1: error P7301: ");
  EXPECT_NE(first_problem("[inputs]\n%IX0.0 = { driver = \"a\" }\n").find("help: addresses are written in quotes"),
            std::string::npos);
  EXPECT_NE(first_problem("[outputs]\nlisten = \"off\"\n").find("help: \"listen\" belongs to [modbus]"),
            std::string::npos)
      << "its heading is still commented out";
  EXPECT_NE(first_problem("[modbus]\nmax_clients = 2000\n").find("a whole number from 1 to 1024"), std::string::npos);
  EXPECT_NE(first_problem("[inputs]\nMain.Start = { driver = \"a\" }\n").find("\"Main.Start\" = { driver = .. }"),
            std::string::npos);
}

TEST(ConfigurationHelp, RepeatsNothingThatATerminalWouldObey) {
  core::Diagnostics diagnostics;
  read_configuration("[inputs]\nX = { driver = \"a\\u001b[31m\" }\n", "plc.toml", driver_types(), diagnostics);
  ASSERT_NE(diagnostics.error_count(), 0u);
  std::string all;
  for (const core::Diagnostic& d : diagnostics.all()) all += diagnostics.render_one(d);
  EXPECT_NE(all.find("[drivers.a?[31m]"), std::string::npos) << all;
}

TEST(ConfigurationLimits, DepthIsBounded) {
  std::string dotted = "a";
  for (int i = 0; i < 500'000; ++i) dotted += ".a";
  EXPECT_EQ(first_problem(dotted + " = 1\n").substr(0, 29), "plc.toml:1:34: error P7302: n");
  EXPECT_NE(first_problem("[" + dotted + "]\n").find("P7302"), std::string::npos);
  EXPECT_NE(first_problem("a = " + std::string(400'000, '[')).find("plc.toml:1:21: error P7302"), std::string::npos);
  std::string tables = "a = ";
  for (int i = 0; i < 1000; ++i) tables += "{a=";
  EXPECT_NE(first_problem(tables).find("P7302"), std::string::npos);
  // The same dots and brackets in texts and comments are nobody's business.
  EXPECT_EQ(first_problem("# " + dotted + "\n[modbus]\nwritable = [\"" + dotted + "\", '" + std::string(99, '[') +
                          "', \"\"\"" + dotted + "\"\"\"\"\"]\n"),
            "");
}

TEST(ConfigurationLimits, NamesInOtherAlphabets) {
  EXPECT_EQ(first_problem("\xef\xbb\xbf# \xc3\xa9\n[drivers.a]\nkind = \"simulated\"\ntask = '\xc3\xa9'\n[inputs]\n"
                          "\"P\xc3\xa9.\xd2\x93\" = { driver = \"a\" }\n\"\"\"no key\"\"\" = 1\n"),
            "plc.toml:7:1: error P7301: in a key: multi-line strings are prohibited in keys");
  EXPECT_EQ(first_problem("[inputs]\n\"P\xc3\xa9.\xd2\x93\" = { driver = \"a\" }\n").substr(0, 15), "plc.toml:2:21: ")
      << "columns count characters, not bytes";
}

TEST(ConfigurationLimits, EveryFormOfTomlPasses) {
  EXPECT_EQ(
      first_problem("[drivers.a] # \xc3\xa9\nkind=\"simulated\"\n[inputs]\n'x'.driver=\"a\"\nx1 . \"driver\" = 'a'\n"
                    "\"\xc3\xa9\" = {driver=\"a\",channel=\"\\\"\xc3\xa9\"}#\"\n"
                    "[outputs.\"\xc3\xa9.1\"]\n\"driver\"='''a'''\nsafe = 1.5\n"
                    "[modbus]\nexported=[\"\"\"\xc3\xa9\"\"\",\n'\xc3\xa9' , #\xc3\xa9\n\"a\" ]\nread_only=true\n"
                    "[[ modbus . \"range\" ]]\n\"table\" = \"coils\"\n[guardian]\nenabled=true\t#'\n"),
      "");
}

TEST(ConfigurationLimits, SizeIsBounded) {
  EXPECT_EQ(first_problem(std::string(4'000'000, '\n')), "");
  EXPECT_NE(first_problem(std::string(4'000'001, '\n')).find("P7302"), std::string::npos);
}

TEST(ConfigurationLimits, AFileOfMistakesStaysReadable) {
  std::string text = "[inputs]\n";
  for (int i = 0; i < 60'000; ++i) text += "V" + std::to_string(i) + " = { driver = \"d" + std::to_string(i) + "\" }\n";
  core::Diagnostics diagnostics;
  EXPECT_FALSE(read_configuration(text, "plc.toml", driver_types(), diagnostics).has_value());
  EXPECT_LE(diagnostics.all().size(), core::Diagnostics::kMaxKept);
  EXPECT_GE(diagnostics.error_count(), 1000u);
}

TEST(ConfigurationFile, AbsentFileIsP7001) {
  core::Diagnostics diagnostics;
  EXPECT_FALSE(load_configuration("/nowhere/plc.toml", driver_types(), diagnostics).has_value());
  EXPECT_FALSE(load_configuration("/dev", driver_types(), diagnostics).has_value());
  ASSERT_EQ(diagnostics.all().size(), 2u);
  for (const core::Diagnostic& d : diagnostics.all()) EXPECT_EQ(core::info(d.code).name, "P7001");
}

}  // namespace
}  // namespace plc::io
