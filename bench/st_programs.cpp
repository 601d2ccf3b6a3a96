#include "bench/st_programs.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace plc::bench {
namespace {

/// A variable of an interface; with `rows` an array from 0, with `columns` of two dimensions.
struct Declared {
  std::string name;
  std::string_view type;
  std::uint32_t rows = 0, columns = 0;
};

std::string declare(const std::vector<Declared>& variables) {
  std::string out;
  for (const Declared& variable : variables) {
    // Elementary types are elements of their own name, all others are named.
    const bool elementary = variable.type == "BOOL" || variable.type == "DINT" || variable.type == "REAL" ||
                            variable.type == "DWORD" || variable.type == "BYTE";
    std::string type =
        elementary ? fmt::format("<{}/>", variable.type) : fmt::format("<derived name=\"{}\"/>", variable.type);
    const auto dimension = [](std::uint32_t count) {
      return fmt::format(R"(<dimension lower="0" upper="{}"/>)", count - 1);
    };
    if (variable.rows != 0) {
      type = fmt::format("<array>{}{}<baseType>{}</baseType></array>", dimension(variable.rows),
                         variable.columns == 0 ? "" : dimension(variable.columns), type);
    }
    out += fmt::format("<variable name=\"{}\"><type>{}</type></variable>\n", variable.name, type);
  }
  return out;
}

std::string pou(std::string_view name, const std::vector<Declared>& locals, const std::vector<Declared>& externals,
                std::string_view body) {
  return fmt::format(
      "<pou name=\"{}\" pouType=\"program\"><interface><localVars>\n{}</localVars>{}</interface>\n"
      "<body><ST><xhtml:p><![CDATA[{}]]></xhtml:p></ST></body></pou>\n",
      name, declare(locals),
      externals.empty() ? "" : fmt::format("<externalVars>\n{}</externalVars>", declare(externals)), body);
}

std::string project(std::string_view pous, std::string_view resource) {
  return fmt::format(
      "<?xml version='1.0' encoding='utf-8'?>\n"
      "<project xmlns=\"http://www.plcopen.org/xml/tc6_0201\" xmlns:xhtml=\"http://www.w3.org/1999/xhtml\">\n"
      "<fileHeader companyName=\"PICARD\" productName=\"plc-bench\" productVersion=\"1\" "
      "creationDateTime=\"2024-01-01T00:00:00\"/>\n"
      "<contentHeader name=\"bench\"><coordinateInfo><fbd><scaling x=\"10\" y=\"10\"/></fbd><ld><scaling x=\"10\" "
      "y=\"10\"/></ld><sfc><scaling x=\"10\" y=\"10\"/></sfc></coordinateInfo></contentHeader>\n"
      "<types><dataTypes/><pous>\n{}</pous></types>\n<instances><configurations><configuration name=\"Config0\">"
      "<resource name=\"Res0\">\n{}</resource></configuration></configurations></instances>\n</project>\n",
      pous, resource);
}

std::string task(std::string_view program, std::uint32_t priority) {
  return fmt::format(
      "<task name=\"task{0}\" priority=\"{0}\" interval=\"T#20ms\"><pouInstance name=\"{1}\" typeName=\"{1}_t\"/>"
      "</task>\n",
      priority, program);
}

/// One program "Main" in one task. A '$N' in either text is the size, '$L' the size less 1, '$S' a number of the seed.
/// After what the size counts: gcc carries no value past it.
const std::string kBarrier = "#ifndef BARRIER\n#define BARRIER __asm__ volatile(\"\" ::: \"memory\");\n#endif\n";

Source single(std::uint32_t size, std::uint64_t seed, const std::vector<Declared>& locals, std::string_view st,
              std::string_view c, std::vector<Variable> variables) {
  const auto fill = [&](std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '$') {
        out += text[i];
        continue;
      }
      const char what = text[++i];
      out += std::to_string(what == 'N' ? size : what == 'L' ? size - 1 : seed % 1000);
    }
    return out;
  };
  return {project(pou("Main_t", locals, {}, fill(st)), task("Main", 0)), {kBarrier + fill(c)}, std::move(variables)};
}

}  // namespace

Source make_products(std::uint32_t size, std::uint64_t seed) {
  // What is multiplied is made once, in the first scan: it is not what is measured.
  return single(size, seed,
                {{"a", "REAL", size}, {"b", "REAL", size}, {"out", "DINT", size}, {"i", "DINT"}, {"made", "BOOL"}},
                R"(
IF NOT made THEN
  FOR i := 0 TO $L DO
    a[i] := DINT_TO_REAL(i + $S) / 7.0;
    b[i] := DINT_TO_REAL(i MOD 1000) - 499.5;
  END_FOR;
  made := TRUE;
END_IF;
FOR i := 0 TO $L DO
  out[i] := REAL_TO_DINT(a[i] * b[i]);
END_FOR;
)",
                R"(#include <math.h>
static int out[$N], i;
static float a[$N], b[$N];
static unsigned char made;
void plc_scan(long long now) {
  (void)now;
  if (!made) {
    for (i = 0; i <= $L; ++i) {
      a[i] = (float)(i + $S) / 7.0f;
      b[i] = (float)(i % 1000) - 499.5f;
    }
    made = 1;
  }
  for (i = 0; i <= $L; ++i) {
    out[i] = (int)lrintf(a[i] * b[i]);
    BARRIER
  }
}
)",
                {{"Main.out[0]", "out", 4 * size}, {"Main.i", "i", 4}, {"Main.made", "made", 1}});
}

Source make_bubble(std::uint32_t size, std::uint64_t seed) {
  return single(size, seed,
                {{"out", "DINT", size},
                 {"i", "DINT"},
                 {"first", "DINT"},
                 {"last", "DINT"},
                 {"keep", "DINT"},
                 {"swapped", "BOOL"}},
                R"(
FOR i := 0 TO $L DO
  out[i] := $N - i + $S;
END_FOR;
FOR first := 0 TO $L BY 100 DO
  last := MIN(first + 99, $L);
  REPEAT
    swapped := FALSE;
    FOR i := first + 1 TO last DO
      IF out[i - 1] > out[i] THEN
        keep := out[i];
        out[i] := out[i - 1];
        out[i - 1] := keep;
        swapped := TRUE;
      END_IF;
    END_FOR;
  UNTIL NOT swapped
  END_REPEAT;
END_FOR;
)",
                R"(static int out[$N], i, first, last, keep;
static unsigned char swapped;
void plc_scan(long long now) {
  (void)now;
  for (i = 0; i <= $L; ++i) out[i] = $N - i + $S;
  for (first = 0; first <= $L; first += 100) {
    last = first + 99 < $L ? first + 99 : $L;
    do {
      swapped = 0;
      for (i = first + 1; i <= last; ++i) {
        if (out[i - 1] > out[i]) {
          keep = out[i];
          out[i] = out[i - 1];
          out[i - 1] = keep;
          swapped = 1;
        }
      }
    } while (swapped);
    BARRIER
  }
}
)",
                {{"Main.out[0]", "out", 4 * size},
                 {"Main.i", "i", 4},
                 {"Main.first", "first", 4},
                 {"Main.last", "last", 4},
                 {"Main.keep", "keep", 4},
                 {"Main.swapped", "swapped", 1}});
}

Source make_fir(std::uint32_t size, std::uint64_t seed) {
  return single(size, seed,
                {{"x", "REAL", size + 31},
                 {"h", "REAL", 32},
                 {"y", "REAL", size},
                 {"sample", "REAL"},
                 {"sum", "REAL"},
                 {"i", "DINT"},
                 {"j", "DINT"},
                 {"made", "BOOL"}},
                R"(
IF NOT made THEN
  FOR i := 0 TO $N + 30 DO
    x[i] := DINT_TO_REAL((i * 37 + $S) MOD 200 - 100) / 8.0;
  END_FOR;
  FOR j := 0 TO 31 DO
    h[j] := 1.0 / DINT_TO_REAL(j + 1);
  END_FOR;
  made := TRUE;
END_IF;
x[16] := sample;
FOR i := 0 TO $L DO
  sum := 0.0;
  FOR j := 0 TO 31 DO
    sum := sum + h[j] * x[i + j];
  END_FOR;
  y[i] := sum;
END_FOR;
)",
                R"(static float x[$N + 31], h[32], y[$N], sample, sum;
static int i, j;
static unsigned char made;
void plc_scan(long long now) {
  (void)now;
  if (!made) {
    for (i = 0; i <= $N + 30; ++i) x[i] = (float)((i * 37 + $S) % 200 - 100) / 8.0f;
    for (j = 0; j <= 31; ++j) h[j] = 1.0f / (float)(j + 1);
    made = 1;
  }
  x[16] = sample;
  for (i = 0; i <= $L; ++i) {
    sum = 0;
    for (j = 0; j <= 31; ++j) sum = sum + h[j] * x[i + j];
    y[i] = sum;
    BARRIER
  }
}
)",
                {{"Main.sample", "sample", 4, Stimulus::kReal},
                 {"Main.y[0]", "y", 4 * size},
                 {"Main.sum", "sum", 4},
                 {"Main.i", "i", 4},
                 {"Main.j", "j", 4}});
}

Source make_matrix(std::uint32_t size, std::uint64_t seed) {
  return single(size, seed,
                {{"a", "REAL", size, 16},
                 {"b", "REAL", 16, 16},
                 {"c", "REAL", size, 16},
                 {"sample", "REAL"},
                 {"sum", "REAL"},
                 {"i", "DINT"},
                 {"j", "DINT"},
                 {"k", "DINT"},
                 {"made", "BOOL"}},
                R"(
IF NOT made THEN
  FOR i := 0 TO $L DO
    FOR j := 0 TO 15 DO
      a[i, j] := DINT_TO_REAL((i * 31 + j * 17 + $S) MOD 200 - 100) / 8.0;
    END_FOR;
  END_FOR;
  FOR i := 0 TO 15 DO
    FOR j := 0 TO 15 DO
      b[i, j] := DINT_TO_REAL((i * 13 + j * 29 + $S) MOD 200 - 100) / 8.0;
    END_FOR;
  END_FOR;
  made := TRUE;
END_IF;
a[1, 2] := sample;
FOR i := 0 TO $L DO
  FOR j := 0 TO 15 DO
    sum := 0.0;
    FOR k := 0 TO 15 DO
      sum := sum + a[i, k] * b[k, j];
    END_FOR;
    c[i, j] := sum;
  END_FOR;
END_FOR;
)",
                R"(static float a[$N][16], b[16][16], c[$N][16], sample, sum;
static int i, j, k;
static unsigned char made;
void plc_scan(long long now) {
  (void)now;
  if (!made) {
    for (i = 0; i <= $L; ++i) {
      for (j = 0; j <= 15; ++j) a[i][j] = (float)((i * 31 + j * 17 + $S) % 200 - 100) / 8.0f;
    }
    for (i = 0; i <= 15; ++i) {
      for (j = 0; j <= 15; ++j) b[i][j] = (float)((i * 13 + j * 29 + $S) % 200 - 100) / 8.0f;
    }
    made = 1;
  }
  a[1][2] = sample;
  for (i = 0; i <= $L; ++i) {
    for (j = 0; j <= 15; ++j) {
      sum = 0;
      for (k = 0; k <= 15; ++k) sum = sum + a[i][k] * b[k][j];
      c[i][j] = sum;
    }
    BARRIER
  }
}
)",
                {{"Main.sample", "sample", 4, Stimulus::kReal},
                 {"Main.c[0,0]", "c", 4 * 16 * size},
                 {"Main.sum", "sum", 4},
                 {"Main.i", "i", 4},
                 {"Main.j", "j", 4},
                 {"Main.k", "k", 4}});
}

Source make_checksum(std::uint32_t size, std::uint64_t seed) {
  return single(
      size, seed,
      {{"data", "BYTE", size}, {"crc", "DWORD"}, {"start", "DINT"}, {"i", "DINT"}, {"bit", "DINT"}, {"made", "BOOL"}},
      R"(
IF NOT made THEN
  FOR i := 0 TO $L DO
    data[i] := DINT_TO_BYTE((i * 37 + $S) MOD 256);
  END_FOR;
  made := TRUE;
END_IF;
crc := DINT_TO_DWORD(start);
FOR i := 0 TO $L DO
  crc := crc XOR BYTE_TO_DWORD(data[i]);
  FOR bit := 1 TO 8 DO
    IF (crc AND 1) <> 0 THEN
      crc := SHR(crc, 1) XOR 16#EDB88320;
    ELSE
      crc := SHR(crc, 1);
    END_IF;
  END_FOR;
END_FOR;
)",
      R"(static unsigned char data[$N], made;
static unsigned crc;
static int start, i, bit;
void plc_scan(long long now) {
  (void)now;
  if (!made) {
    for (i = 0; i <= $L; ++i) data[i] = (unsigned char)((i * 37 + $S) % 256);
    made = 1;
  }
  crc = (unsigned)start;
  for (i = 0; i <= $L; ++i) {
    crc ^= data[i];
    for (bit = 1; bit <= 8; ++bit) {
      if (crc & 1) crc = crc >> 1 ^ 0xEDB88320u;
      else crc >>= 1;
    }
    BARRIER
  }
}
)",
      {{"Main.start", "start", 4, Stimulus::kDint},
       {"Main.crc", "crc", 4},
       {"Main.i", "i", 4},
       {"Main.bit", "bit", 4}});
}

Source make_calls(std::uint32_t size, std::uint64_t) {
  std::vector<Declared> locals;
  std::string body;
  std::vector<Variable> variables;
  for (std::uint32_t i = 0; i < size; ++i) {
    locals.push_back({fmt::format("b{}", i), "ONE_WORKING"});
    body += i == 0 ? "b0();\n" : fmt::format("b{}(IN1 := b{}.OUT1);\n", i, i - 1);
    variables.push_back({fmt::format("Main.b{}.OUT1", i), {}, 8, Stimulus::kNone});
  }
  Source source;
  source.project = project(pou("Main_t", locals, {}, body), task("Main", 0));
  source.c = {
      fmt::format("#pragma GCC visibility push(default)\n"
                  "struct {{ int (*fire)(void *object, void *failure); void *object; }} plc_calls[{0}];\n"
                  "void *plc_failure;\n"
                  "#pragma GCC visibility pop\n"
                  "void plc_scan(long long now) {{\n"
                  "  (void)now;\n"
                  "  for (int i = 0; i < {0}; ++i) {{\n"
                  "    if (!plc_calls[i].fire(plc_calls[i].object, plc_failure)) return;\n"
                  "  }}\n"
                  "}}\n",
                  size)};
  source.variables = std::move(variables);
  source.taskblocks = size;
  return source;
}

Source make_exchange(std::uint32_t size, std::uint64_t seed) {
  // Each task touches a few elements, so that the copies are what is measured.
  const std::vector<Declared> globals = {{"there", "DINT", size}, {"back", "DINT", size}};
  const std::string xml =
      project(pou("Near_t", {{"at", "DINT"}, {"step", "DINT"}, {"got", "DINT"}}, globals,
                  fmt::format("at := (at + 7) MOD {};\nthere[at] := there[at] + step + {};\ngot := back[at / 2];\n",
                              size, seed % 1000)) +
                  pou("Far_t", {{"at", "DINT"}, {"got", "DINT"}}, globals,
                      fmt::format("at := (at + 7) MOD {};\nback[at] := there[at] * 3;\ngot := there[at / 2];\n", size)),
              task("Near", 0) + task("Far", 1) + fmt::format("<globalVars>\n{}</globalVars>\n", declare(globals)));
  // The local copies of both tasks and what lies between them; each takes what the other one has given, runs, and
  // gives.
  const std::string c = fmt::format(
      R"(#include <string.h>
#define N {}
static int there[N], back[N];
static struct {{ int there[N], back[N], at, step, got; }} near, far;
static void run_near(void) {{
  near.at = (near.at + 7) % N;
  near.there[near.at] = (int)((unsigned)near.there[near.at] + (unsigned)near.step + {}u);
  near.got = near.back[near.at / 2];
}}
static void run_far(void) {{
  far.at = (far.at + 7) % N;
  far.back[far.at] = (int)((unsigned)far.there[far.at] * 3);
  far.got = far.there[far.at / 2];
}}
void plc_scan(long long now) {{
  (void)now;
  memcpy(near.back, back, sizeof back);
  BARRIER
  run_near();
  BARRIER
  memcpy(there, near.there, sizeof there);
  BARRIER
  memcpy(far.there, there, sizeof there);
  BARRIER
  run_far();
  BARRIER
  memcpy(back, far.back, sizeof back);
}}
)",
      size, seed % 1000);
  return {xml,
          {kBarrier + c},
          {{"Near.step", "near.step", 4, Stimulus::kDint},
           {"Near.got", "near.got", 4, Stimulus::kNone},
           {"Far.got", "far.got", 4, Stimulus::kNone},
           {"there[0]", "near.there", 4 * size, Stimulus::kNone},
           {"back[0]", "near.back", 4 * size, Stimulus::kNone}}};
}

}  // namespace plc::bench
