# Headers that most sources include are compiled once for all of PICARD, and once with GoogleTest for its tests: parsing
# them in every source took a fifth of a build. Each source includes what it uses all the same: clang-tidy, and builds with
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON, have no such headers.
set(PLC_COMMON_HEADERS
  <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstring> <fstream> <functional>
  <iostream> <iterator> <limits> <map> <memory> <mutex> <optional> <set> <span> <sstream> <string> <string_view>
  <system_error> <unordered_map> <utility> <variant> <vector> <fmt/format.h>)
set(PLC_TEST_HEADERS ${PLC_COMMON_HEADERS} <random> <regex> <thread> <gtest/gtest.h>)

# plc_precompile(target): the target takes the common headers; plc_core, the first library, compiles them.
function(plc_precompile target)
  if(target STREQUAL plc_core)
    target_precompile_headers(${target} PRIVATE ${PLC_COMMON_HEADERS})
  else()
    target_precompile_headers(${target} REUSE_FROM plc_core)
  endif()
endfunction()

# plc_compile_small(target): for its size, in releases. WHY not all: engines and the reading of large projects are slower so.
# The first such target compiles the common headers with these options.
function(plc_compile_small target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release,None>:-Os>)
  get_property(first GLOBAL PROPERTY PLC_FIRST_SMALL)
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    target_precompile_headers(${target} PRIVATE ${PLC_COMMON_HEADERS})
    set_property(GLOBAL PROPERTY PLC_FIRST_SMALL ${target})
  endif()
endfunction()

# plc_gtest(target): the target runs GoogleTest; test_core, the first of them, compiles the headers of tests.
function(plc_gtest target)
  target_link_libraries(${target} PRIVATE GTest::gtest GTest::gtest_main)
  if(target STREQUAL test_core)
    target_precompile_headers(${target} PRIVATE ${PLC_TEST_HEADERS})
  else()
    target_precompile_headers(${target} REUSE_FROM test_core)
  endif()
endfunction()
