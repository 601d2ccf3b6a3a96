// The address of the Modbus server, as far as the kernel's tables tell: nothing is bound to try it.
#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

#include "doctor/check.h"
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
/// Who listens where the server is to listen; nothing when nobody does.
std::optional<Holder> listener(const Context& c) {
  const auto ours = parse_address(modbus(c).address);
  const std::string tables = c.system.read("/proc/net/tcp").value_or("") + c.system.read("/proc/net/tcp6").value_or("");
  for (const std::string_view line : lines_of(tables)) {
    // "  0: 0100007F:01F6 00000000:0000 0A .. uid timeout inode"
    const auto words = words_of(line);
    if (!ours || words.size() < 10 || words[3] != "0A") continue;
    const std::size_t colon = words[1].find(':');
    const auto theirs = parse_words(words[1].substr(0, colon));
    if (!theirs || colon == std::string_view::npos || to_number(words[1].substr(colon + 1), 16) != modbus(c).port)
      continue;
    if (*theirs == *ours || is_any(*theirs) || is_any(*ours)) return holder_of(c, words[9]);
  }
  return std::nullopt;
}
std::string listen_text(const Context& c) { return io::listen_text({modbus(c).address, modbus(c).port}); }
/// What there is to say when no server is looked at.
std::optional<Outcome> without_server(const Context& c) {
  if (!c.subject.configuration_is_known) return unknown("plc.toml has errors");
  if (!modbus(c).enabled) return fine("off");
  return std::nullopt;
}
/// Where nothing says what to listen on, plc-run goes on without Modbus.
Outcome no_listening(const Context& c, std::string seen, std::string help) {
  Outcome outcome = wrong(std::move(seen), std::move(help));
  if (modbus(c).listen_at.line == 0) outcome.found[0].severity = core::Severity::kWarning;
  return outcome;
}

}  // namespace

Outcome check_listen_address(const Context& c) {
  if (auto outcome = without_server(c)) return *outcome;
  const auto address = parse_address(modbus(c).address);
  if (!address) return unknown("listen is no address");
  if (is_any(*address) || is_loopback(*address)) return fine(listen_text(c));
  const std::set<Address> known = addresses(c);
  if (known.empty()) return unknown("the addresses of the machine are not known");
  if (known.count(*address) == 1) return fine(listen_text(c));
  return no_listening(
      c, modbus(c).address + " is no address of this machine now",
      "`ip address` lists them; where a network comes up late: After=network-online.target in the service, or "
      "listen on 0.0.0.0 or [::]");
}

Outcome check_port_right(const Context& c) {
  if (auto outcome = without_server(c)) return *outcome;
  const std::int64_t first = c.system.number("/proc/sys/net/ipv4/ip_unprivileged_port_start").value_or(1024);
  if (modbus(c).port == 0 || modbus(c).port >= first) return fine("needs none");
  if (!c.process.known()) return unknown("the rights of the process are not known");
  if (c.process.has(Capability::kNetBindService)) return fine("CAP_NET_BIND_SERVICE");
  if (const auto holder = listener(c); holder && holder->serves_plants()) return fine("opened by " + holder->name);
  return no_listening(
      c, fmt::format("ports below {} need CAP_NET_BIND_SERVICE, which the process has not: {}", first, listen_text(c)),
      "have systemd open it, as picard@NAME.socket does, or take another port: listen = \"127.0.0.1:1502\"");
}

Outcome check_port(const Context& c) {
  if (auto outcome = without_server(c)) return *outcome;
  if (!parse_address(modbus(c).address) || modbus(c).port == 0) return fine("any free one");
  if (!c.system.read("/proc/net/tcp")) return missing("/proc/net/tcp");
  const auto holder = listener(c);
  if (!holder) return fine(listen_text(c) + " is free");
  if (holder->serves_plants())
    return fine(fmt::format("{}, served by {}, process {}", listen_text(c), holder->name, holder->id));
  return no_listening(c,
                      fmt::format("another program listens on {}{}", listen_text(c),
                                  holder->id.empty() ? "" : fmt::format(": {}, process {}", holder->name, holder->id)),
                      "`ss -ltnp` shows which; stop it, or give another port as `listen` under [modbus]");
}

Outcome check_open_network(const Context& c) {
  if (auto outcome = without_server(c)) return *outcome;
  const io::ModbusConfig& config = modbus(c);
  const auto address = parse_address(config.address);
  if (!address || is_loopback(*address)) return fine("this machine only");
  if (config.read_only) return fine("may read, not write");
  if (!config.writable.empty()) return fine("may write what `writable` lists");
  return wrong(fmt::format("who reaches {} may write all variables: Modbus has no passwords", listen_text(c)),
               "`writable` or `read_only` under [modbus], and a firewall (nft) that lets HMIs alone through");
}

Outcome check_frozen_addresses(const Context& c) {
  if (auto outcome = without_server(c)) return *outcome;
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
