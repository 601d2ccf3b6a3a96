# Warnings, sanitizers and build switches as one interface target, never as global flags.
option(PLC_TESTS "Build the tests" ON)
option(PLC_BENCH "Build the benchmarks" ON)
option(PLC_FUZZ "Build the libFuzzer targets (clang only)" OFF)
set(PLC_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them: address,undefined or thread")

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

add_library(plc_options INTERFACE)
target_compile_features(plc_options INTERFACE cxx_std_20)
# fmt for all: it is one of the precompiled headers, which need the same definitions everywhere.
target_link_libraries(plc_options INTERFACE fmt::fmt)
target_include_directories(plc_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(plc_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor -Werror
  -ffp-contract=off)
# As Debian compiles its packages, so that results which may not be ignored are errors here, too. Not with sanitizers, which
# watch the same functions.
target_compile_definitions(plc_options INTERFACE $<$<CONFIG:Release>:_FORTIFY_SOURCE=2>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # WHY: gcc 12 warns about its own std::string when texts are concatenated (gcc bug 105651).
  target_compile_options(plc_options INTERFACE -Wno-restrict)
endif()
if(PLC_SANITIZE)
  target_compile_options(plc_options INTERFACE -fsanitize=${PLC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(plc_options INTERFACE -fsanitize=${PLC_SANITIZE})
  # WHY: instrumented code hides from gcc that an optional was tested.
  target_compile_options(plc_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(PLC_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "PLC_FUZZ needs clang: use the preset 'fuzz'")
  endif()
  target_compile_options(plc_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
