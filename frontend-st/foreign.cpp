#include "frontend-st/foreign.h"

#include <algorithm>

#include "core/text.h"

namespace plc::st {
namespace {

struct Word {
  std::string_view word;
  Foreign foreign;
};

constexpr Foreign kExceptions{"exception handling of CODESYS and TwinCAT",
                              "test before what may fail: division by zero and bad indices stop nothing here and are "
                              "counted as events"};
constexpr Foreign kMemory{"memory that is taken while the program runs",
                          "declare an instance, or an array that is large enough"};
constexpr Foreign kObjects{"object orientation", "write it as function blocks, functions and structures"};
constexpr Foreign kOperators{"an operator of CODESYS and TwinCAT", ""};
constexpr Foreign kJumps{"a jump inside a text", "use IF and CASE, loops with EXIT and CONTINUE, or RETURN"};

constexpr Word kWords[] = {
    {"__TRY", kExceptions},
    {"__CATCH", kExceptions},
    {"__FINALLY", kExceptions},
    {"__ENDTRY", kExceptions},
    {"__NEW", kMemory},
    {"__DELETE", kMemory},
    {"__QUERYINTERFACE", kObjects},
    {"__QUERYPOINTER", kObjects},
    {"THIS", kObjects},
    {"SUPER", kObjects},
    {"__VARINFO", kOperators},
    {"__POUNAME", kOperators},
    {"__POSITION", kOperators},
    {"__CURRENTTASK", kOperators},
    {"__COMPARE_AND_SWAP", kOperators},
    {"__XADD", kOperators},
    {"TEST_AND_SET", kOperators},
    {"BITADR", kOperators},
    {"INDEXOF", kOperators},
    {"INI", kOperators},
    {"XSIZEOF", kOperators},
    {"JMP", kJumps},
    {"JMPC", kJumps},
    {"GOTO", kJumps},
};

constexpr Foreign kGeneric{"a generic type", "declare the type that is passed, and one function for each type"};
constexpr Foreign kUnicode{"a type of the fourth edition", "use WSTRING and WCHAR"};
constexpr Foreign kWidth{"a type as wide as an address of the controller", "use ULINT or LWORD"};

constexpr Word kTypes[] = {
    {"ANY", kGeneric},
    {"ANY_DERIVED", kGeneric},
    {"ANY_ELEMENTARY", kGeneric},
    {"ANY_MAGNITUDE", kGeneric},
    {"ANY_NUM", kGeneric},
    {"ANY_REAL", kGeneric},
    {"ANY_INT", kGeneric},
    {"ANY_UNSIGNED", kGeneric},
    {"ANY_SIGNED", kGeneric},
    {"ANY_DURATION", kGeneric},
    {"ANY_BIT", kGeneric},
    {"ANY_CHARS", kGeneric},
    {"ANY_STRING", kGeneric},
    {"ANY_CHAR", kGeneric},
    {"ANY_DATE", kGeneric},
    {"USTRING", kUnicode},
    {"UCHAR", kUnicode},
    {"__XWORD", kWidth},
    {"__UXINT", kWidth},
    {"__XINT", kWidth},
    {"BIT", {"a type of a single bit inside of a structure", "use BOOL"}},
};

struct Supplier {
  std::string_view name;  ///< a prefix where it ends with '_', else the whole name
  std::string_view who;
};

constexpr std::string_view kBeremizTarget = "the target library of Beremiz";
constexpr std::string_view kBeremizPython = "the Python extension of Beremiz";
constexpr std::string_view kBeremizHmi = "the SVGHMI extension of Beremiz";
constexpr std::string_view kOpenPlcArduino = "the Arduino library of OpenPLC Editor";
constexpr std::string_view kOpenPlcP1am = "the P1AM library of OpenPLC Editor";
constexpr std::string_view kOpenPlcMqtt = "the MQTT library of OpenPLC Editor";
constexpr std::string_view kOpenPlcCommunication = "the communication library of OpenPLC Editor";
constexpr std::string_view kOpenPlcSequent = "the Sequent Microsystems library of OpenPLC Editor";
constexpr std::string_view kMotion = "a PLCopen motion library";

constexpr Supplier kSuppliers[] = {
    {"LOGGER", kBeremizTarget},
    {"LOGLEVEL", kBeremizTarget},
    {"HMI_", kBeremizHmi},
    {"SVGHMI_", kBeremizHmi},
    {"PYTHON_", kBeremizPython},
    {"PY_", kBeremizPython},
    {"P1AM_", kOpenPlcP1am},
    {"P1_", kOpenPlcP1am},
    {"DS18B20", kOpenPlcArduino},
    {"DS18B20_", kOpenPlcArduino},
    {"CLOUD_", kOpenPlcArduino},
    {"PWM_CONTROLLER", kOpenPlcArduino},
    {"ARDUINO_", kOpenPlcArduino},
    {"ARDUINOCAN_", kOpenPlcArduino},
    {"STM32CAN_", kOpenPlcArduino},
    {"ADC_CONFIG", "the Jaguar library of OpenPLC Editor"},
    {"SM_", kOpenPlcSequent},
    {"MQTT_", kOpenPlcMqtt},
    {"TCP_", kOpenPlcCommunication},
    {"MC_", kMotion},
    {"SMC_", "the SoftMotion library of CODESYS"},
    {"AXIS_REF", kMotion},
    {"SYS_", "a system library of the tool"},
    {"ADS_", "a library of TwinCAT"},
    {"FB_", "probably a library of the tool"},
};

bool starts_with(std::string_view text, std::string_view prefix) {
  return text.size() >= prefix.size() && core::iequals(text.substr(0, prefix.size()), prefix);
}

/// The text without what is in quotes, and without ":=", which C does not have.
std::string unquoted(std::string_view text) {
  std::string out;
  char quote = '\0';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (text.substr(i).starts_with(":=")) {
      ++i;
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::optional<Foreign> foreign_word(std::string_view word) {
  for (const Word& one : kWords) {
    if (core::iequals(one.word, word)) return one.foreign;
  }
  return std::nullopt;
}

std::optional<Foreign> foreign_type(std::string_view name) {
  if (starts_with(name, "__SYSTEM.")) return kOperators;
  for (const Word& one : kTypes) {
    if (core::iequals(one.word, name)) return one.foreign;
  }
  return std::nullopt;
}

bool is_c_code(std::string_view pragma) {
  if (pragma.starts_with("{{")) return true;
  const std::string text = unquoted(pragma.substr(0, std::size_t{1} << 16));
  // Pragmas of the standard and of tools are words and assignments; a statement of C ends with a semicolon.
  const bool statement = text.find(';') != std::string::npos && text.find_first_of("(=") != std::string::npos;
  if (statement || text.find("->") != std::string::npos) return true;
  const std::string_view inner = core::trimmed(std::string_view(text).substr(std::min<std::size_t>(1, text.size())));
  return inner.starts_with("#include") || inner.starts_with("#define") || inner.starts_with("extern ");
}

std::string_view supplier_of(std::string_view name) {
  for (const Supplier& one : kSuppliers) {
    if (one.name.ends_with('_') ? starts_with(name, one.name) : core::iequals(name, one.name)) return one.who;
  }
  return {};
}

std::string supply_help(std::string_view name, std::string_view declaration) {
  const std::string_view who = supplier_of(name);
  std::string help = who.empty() ? "" : std::string(who) + " brings it: ";
  help += "name a file that declares it (--lib), as in " + std::string(declaration) +
          "; --stub-missing runs the rest without it";
  return help;
}

}  // namespace plc::st
