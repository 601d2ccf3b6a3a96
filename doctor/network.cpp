// Addresses of the Modbus server and the engineering server, as far as the kernel's tables tell: nothing is bound to
// try them. The certificate of the engineering server.
#include <arpa/inet.h>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

#include "doctor/check.h"
#include "engineering/certificate.h"
#include "io-drivers/modbus/address_map.h"

namespace plc::doctor {
namespace {

/// An address as IPv6 has it; IPv4 as ::ffff:a.b.c.d.
using Address = std::array<unsigned char, 16>;

std::optional<Address> parse_address(const std::string& text) {
  Address address{};
  if (::inet_pton(AF_INET6, text.c_str(), address.data()) == 1) return address;
  if (::inet_pton(AF_INET, text.c_str(), address.data() + 12) != 1) return std::nullopt;
  address[10] = address[11] = 0xff;
  return address;
}
bool is_four(const Address& address) { return address[10] == 0xff && address[11] == 0xff && address[0] == 0; }
bool is_any(const Address& address) {
  const std::size_t from = is_four(address) ? 12 : 0;
  return std::all_of(address.begin() + from, address.end(), [](unsigned char byte) { return byte == 0; });
}
bool is_loopback(const Address& address) {
  return is_four(address) ? address[12] == 127 : address == parse_address("::1");
}

/// Hexadecimal, in words of the machine, as /proc/net/tcp has them.
std::optional<Address> parse_words(std::string_view text) {
  Address address{};
  if (text.size() != 8 && text.size() != 32) return std::nullopt;
  const std::size_t from = text.size() == 8 ? 12 : 0;
  if (from != 0) address[10] = address[11] = 0xff;
  for (std::size_t at = 0; at < text.size(); at += 8) {
    const auto word = to_number(text.substr(at, 8), 16);
    if (!word) return std::nullopt;
    const auto value = static_cast<std::uint32_t>(*word);
    std::memcpy(address.data() + from + at / 2, &value, sizeof value);
  }
  return address;
}

/// Addresses of the machine's interfaces; empty: not known.
std::set<Address> addresses(const Context& c) {
  std::set<Address> found;
  const std::string four = c.system.read("/proc/net/fib_trie").value_or("");
  std::string last;
  for (const std::string_view line : lines_of(four)) {
    const std::size_t leaf = line.find("|-- ");
    if (leaf != std::string_view::npos) last = line.substr(leaf + 4);
    if (line.find("host LOCAL") == std::string_view::npos) continue;
    if (const auto address = parse_address(last)) found.insert(*address);
  }
  const std::string six = c.system.read("/proc/net/if_inet6").value_or("");
  for (const std::string_view line : lines_of(six)) {
    if (line.size() < 32) continue;
    Address address{};
    for (std::size_t i = 0; i < address.size(); ++i) {
      address[i] = static_cast<unsigned char>(to_number(line.substr(2 * i, 2), 16).value_or(0));
    }
    found.insert(address);
  }
  return found;
}

/// "1234 (plc-run)", as far as this process may know who has a socket.
struct Holder {
  std::string id, name;
  /// plc-run, or systemd, which opened it for one.
  [[nodiscard]] bool serves_plants() const { return name == "plc-run" || (id == "1" && name == "systemd"); }
};
Holder holder_of(const Context& c, std::string_view inode) {
  const std::string wanted = "socket:[" + std::string(inode) + "]";
  for (const std::string& id : c.system.list("/proc")) {
    if (!to_number(id)) continue;
    for (const std::string& file : c.system.list("/proc/" + id + "/fd")) {
      if (c.system.link("/proc/" + id + "/fd/" + file) != wanted) continue;
      return {id, c.system.line("/proc/" + id + "/comm").value_or("?")};
    }
  }
  return {};
}

const io::ModbusConfig& modbus(const Context& c) { return c.subject.configuration.modbus; }
const io::EngineeringConfig& engineering_of(const Context& c) { return c.subject.configuration.engineering; }

/// What is listened on.
struct Server {
  std::string_view section;  ///< of plc.toml
  bool enabled;
  bool named;  ///< plc.toml says where. Otherwise plc-run goes on without the server.
  const std::string& address;
  std::uint16_t port;
  std::string_view elsewhere;  ///< help: an address without a right

  [[nodiscard]] std::string text() const { return io::listen_text({address, port}); }
};
Server modbus_server(const Context& c) {
  const io::ModbusConfig& config = modbus(c);
  return {"modbus",
          config.enabled,
          config.listen_at.line != 0,
          config.address,
          config.port,
          "have systemd open it, as picard@NAME.socket does, or take another port: listen = \"127.0.0.1:1502\""};
}
Server engineering_server(const Context& c) {
  const io::EngineeringConfig& config = engineering_of(c);
  return {"engineering",  config.enabled, config.listen_at.line != 0,
          config.address, config.port,    "take another port: listen = \"127.0.0.1:8061\""};
}

/// Who listens where the server is to listen; nothing when nobody does.
std::optional<Holder> listener(const Context& c, const Server& server) {
  const auto ours = parse_address(server.address);
  const std::string tables = c.system.read("/proc/net/tcp").value_or("") + c.system.read("/proc/net/tcp6").value_or("");
  for (const std::string_view line : lines_of(tables)) {
    // "  0: 0100007F:01F6 00000000:0000 0A .. uid timeout inode"
    const auto words = words_of(line);
    if (!ours || words.size() < 10 || words[3] != "0A") continue;
    const std::size_t colon = words[1].find(':');
    const auto theirs = parse_words(words[1].substr(0, colon));
    if (!theirs || colon == std::string_view::npos || to_number(words[1].substr(colon + 1), 16) != server.port)
      continue;
    if (*theirs == *ours || is_any(*theirs) || is_any(*ours)) return holder_of(c, words[9]);
  }
  return std::nullopt;
}
/// What there is to say when no server is looked at.
std::optional<Outcome> without(const Context& c, const Server& server) {
  if (!c.subject.configuration_is_known) return unknown("plc.toml has errors");
  if (!server.enabled) return fine("off");
  return std::nullopt;
}
Outcome no_listening(const Server& server, std::string seen, std::string help) {
  Outcome outcome = wrong(std::move(seen), std::move(help));
  if (!server.named) outcome.found[0].severity = core::Severity::kWarning;
  return outcome;
}

Outcome check_address(const Context& c, const Server& server) {
  if (auto outcome = without(c, server)) return *outcome;
  const auto address = parse_address(server.address);
  if (!address) return unknown("listen is no address");
  if (is_any(*address) || is_loopback(*address)) return fine(server.text());
  const std::set<Address> known = addresses(c);
  if (known.empty()) return unknown("the addresses of the machine are not known");
  if (known.count(*address) == 1) return fine(server.text());
  return no_listening(
      server, server.address + " is no address of this machine now",
      "`ip address` lists them; where a network comes up late: After=network-online.target in the service, or "
      "listen on 0.0.0.0 or [::]");
}

Outcome check_right(const Context& c, const Server& server) {
  if (auto outcome = without(c, server)) return *outcome;
  const std::int64_t first = c.system.number("/proc/sys/net/ipv4/ip_unprivileged_port_start").value_or(1024);
  if (server.port == 0 || server.port >= first) return fine("needs none");
  if (!c.process.known()) return unknown("the rights of the process are not known");
  if (c.process.has(Capability::kNetBindService)) return fine("CAP_NET_BIND_SERVICE");
  if (const auto holder = listener(c, server); holder && holder->serves_plants())
    return fine("opened by " + holder->name);
  return no_listening(
      server,
      fmt::format("ports below {} need CAP_NET_BIND_SERVICE, which the process has not: {}", first, server.text()),
      std::string(server.elsewhere));
}

Outcome check_free(const Context& c, const Server& server) {
  if (auto outcome = without(c, server)) return *outcome;
  if (!parse_address(server.address) || server.port == 0) return fine("any free one");
  if (!c.system.read("/proc/net/tcp")) return missing("/proc/net/tcp");
  const auto holder = listener(c, server);
  if (!holder) return fine(fmt::format("{} is free", server.text()));
  if (holder->serves_plants())
    return fine(fmt::format("{}, served by {}, process {}", server.text(), holder->name, holder->id));
  return no_listening(
      server,
      fmt::format("another program listens on {}{}", server.text(),
                  holder->id.empty() ? "" : fmt::format(": {}, process {}", holder->name, holder->id)),
      fmt::format("`ss -ltnp` shows which; stop it, or give another port as `listen` under [{}]", server.section));
}

}  // namespace

Outcome check_modbus_address(const Context& c) { return check_address(c, modbus_server(c)); }
Outcome check_modbus_right(const Context& c) { return check_right(c, modbus_server(c)); }
Outcome check_modbus_port(const Context& c) { return check_free(c, modbus_server(c)); }
Outcome check_engineering_address(const Context& c) { return check_address(c, engineering_server(c)); }
Outcome check_engineering_right(const Context& c) { return check_right(c, engineering_server(c)); }
Outcome check_engineering_port(const Context& c) {
  const Server server = engineering_server(c), other = modbus_server(c);
  const auto here = parse_address(server.address), there = parse_address(other.address);
  const bool both = c.subject.configuration_is_known && server.enabled && other.enabled && here && there;
  if (both && server.port != 0 && server.port == other.port && (*here == *there || is_any(*here) || is_any(*there))) {
    return wrong(fmt::format("[modbus] listens on {}, and [engineering] on {}", other.text(), server.text()),
                 "give one of them another port as `listen`");
  }
  return check_free(c, server);
}

Outcome check_certificate(const Context& c) {
  if (auto outcome = without(c, engineering_server(c))) return *outcome;
  const io::Configuration& configuration = c.subject.configuration;
  const io::EngineeringConfig& config = engineering_of(c);
  if (config.certificate.text.empty() != config.key.text.empty()) {
    Outcome outcome =
        wrong(config.key.text.empty() ? "`certificate` is given without `key`" : "`key` is given without `certificate`",
              "give both under [engineering], or neither: then plc-run makes its own");
    outcome.found[0].code = core::Code::P7306;
    return outcome;
  }
  if (config.certificate.text.empty()) return fine("plc-run makes its own when it needs one");
  const auto real = [&](const std::string& name) { return c.system.real(c.system.named(configuration, name)); };
  const auto read = engineering::read_certificate(real(config.certificate.text), real(config.key.text));
  if (!read) {
    Outcome outcome = wrong(read.error().message, read.error().help);
    outcome.found[0].code = read.error().code;
    return outcome;
  }
  const std::string until = fmt::format("{:%Y-%m-%d}", fmt::gmtime(static_cast<std::time_t>(read->until_utc_s)));
  if (!c.system.calls().clocks) return fine("until " + until);
  constexpr std::int64_t kMonth = 2'592'000;  // 30 days, in seconds
  const std::int64_t left = read->until_utc_s - c.system.calls().clocks().time_of_day_s;
  if (left > kMonth) return fine("until " + until);
  Outcome outcome =
      wrong(fmt::format("{} {} on {}", config.certificate.text, left > 0 ? "ends" : "ended", until),
            "renew it: browsers refuse a certificate that has ended, or leave out `certificate` and `key`");
  if (left > 0) outcome.found[0].severity = core::Severity::kWarning;
  return outcome;
}

Outcome check_open_network(const Context& c) {
  if (auto outcome = without(c, modbus_server(c))) return *outcome;
  const io::ModbusConfig& config = modbus(c);
  const auto address = parse_address(config.address);
  if (!address || is_loopback(*address)) return fine("this machine only");
  if (config.read_only) return fine("may read, not write");
  if (!config.writable.empty()) return fine("may write what `writable` lists");
  return wrong(fmt::format("who reaches {} may write all variables: Modbus has no passwords", modbus_server(c).text()),
               "`writable` or `read_only` under [modbus], and a firewall (nft) that lets HMIs alone through");
}

Outcome check_frozen_addresses(const Context& c) {
  if (auto outcome = without(c, modbus_server(c))) return *outcome;
  const io::Configuration& configuration = c.subject.configuration;
  if (c.subject.resource == nullptr) return unknown("needs a project");
  const std::string& named = configuration.modbus.lock_file.text;
  const std::string file = named.empty() ? modbus::lock_file_of(configuration, c.subject.project_file)
                                         : c.system.real(c.system.named(configuration, named));
  auto frozen = modbus::read_frozen(file);
  Outcome outcome;
  if (!frozen) {
    outcome.found.push_back({frozen.error().message, frozen.error().help, frozen.error().code, {}});
    return outcome;
  }
  const std::size_t before = frozen->entries.size();
  core::Diagnostics diagnostics;  // warnings are those of `plc config check`
  const auto map = modbus::AddressMap::build(*c.subject.resource, configuration.modbus, *frozen, diagnostics);
  for (const core::Diagnostic& problem : diagnostics.all()) {
    if (problem.severity == core::Severity::kError) {
      outcome.found.push_back({problem.message, problem.help, problem.code, {}});
    }
  }
  if (!map || !outcome.found.empty()) return outcome;
  const std::size_t fresh = frozen->entries.size() - before;
  if (fresh == 0) return fine(fmt::format("{} in {}", before, file));
  return wrong(
      fmt::format("{} automatic addresses are not in {}: a changed project may move them under HMIs", fresh, file),
      "`plc map PROJECT --freeze` writes the file; take it along with the image");
}

}  // namespace plc::doctor
