# plc_library(name [SOURCES ..] [PUBLIC ..] [PRIVATE ..]): one folder, one static library, one step of the flow.
# Without SOURCES every .cpp of the folder belongs to it.
function(plc_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(NOT ARG_SOURCES)
    file(GLOB ARG_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  endif()
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC plc_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  plc_precompile(${name})
endfunction()
