# plc_library(name [SMALL] [SOURCES ..] [PUBLIC ..] [PRIVATE ..]): one folder, one static library, one step of the flow.
# Without SOURCES every .cpp of the folder belongs to it. SMALL: no part of a scan, and what it does takes no time that
# anybody waits for, so that it is compiled to be small.
function(plc_library name)
  cmake_parse_arguments(ARG "SMALL" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(NOT ARG_SOURCES)
    file(GLOB ARG_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  endif()
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC plc_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  if(ARG_SMALL)
    plc_compile_small(${name})
  else()
    plc_precompile(${name})
  endif()
endfunction()
