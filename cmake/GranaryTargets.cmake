# The few words our CMakeLists.txt files are written in.
include(GNUInstallDirs)

function(granary_compile_options target)
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wno-missing-field-initializers
    -Wno-restrict)  # g++ 12 sees overlaps in std::string that are not there
  if(GRANARY_ASSERTS OR CMAKE_BUILD_TYPE STREQUAL "Debug")
    target_compile_definitions(${target} PUBLIC GRANARY_ASSERTS=1)
  endif()
  if(GRANARY_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=address,undefined -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  endif()
endfunction()

# granary_library(pilot_schedule SOURCES a.cpp LINKS granary::pilot_task [PRIVATE_LINKS hwloc])
function(granary_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(ARG_SOURCES)
    add_library(granary_${name} STATIC ${ARG_SOURCES})
    granary_compile_options(granary_${name})
    target_link_libraries(granary_${name} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
  else()
    add_library(granary_${name} INTERFACE)
    target_include_directories(granary_${name} INTERFACE ${CMAKE_SOURCE_DIR})
    target_link_libraries(granary_${name} INTERFACE ${ARG_LINKS})
  endif()
  add_library(granary::${name} ALIAS granary_${name})
endfunction()

# For what takes little of a run's time: it is compiled in two thirds of the time. (For a whole folder:
# add_compile_options with the same.)
function(granary_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# granary_program(granary-pbm SOURCES main.cpp LINKS ...): build/bin/granary-pbm
function(granary_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  granary_compile_options(${name})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
endfunction()

# granary_embed(TARGET HEADER NAMESPACE name=file ...): files as `inline constexpr std::string_view` in a generated
# header, so that a program carries its templates and schemas wherever it is copied.
function(granary_embed target header namespace)
  set(out ${CMAKE_BINARY_DIR}/generated/${header})
  set(pairs "")
  set(files "")
  foreach(pair ${ARGN})
    string(REGEX MATCH "^([^=]+)=(.+)$" _ ${pair})
    set(file ${CMAKE_MATCH_2})
    if(NOT IS_ABSOLUTE ${file})
      set(file ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    endif()
    list(APPEND pairs "${CMAKE_MATCH_1}=${file}")
    list(APPEND files ${file})
  endforeach()
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} "-DOUT=${out}" "-DNAMESPACE=${namespace}" "-DPAIRS=${pairs}"
            -P ${CMAKE_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${files} ${CMAKE_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
  target_sources(${target} PRIVATE ${out})
  target_include_directories(${target} PRIVATE ${CMAKE_BINARY_DIR}/generated)
endfunction()

# granary_test(unit/pilot/scheduler_test LINKS granary::pilot_schedule LABELS unit [SOURCES more.cpp] [TIMEOUT 60])
# ctest shows and runs a file as one test; labels choose what runs. A file is a program, or, where files are compiled
# together (the preset release), a part of its folder's program. Folders whose tests compute nothing themselves set
# GRANARY_TESTS_AT to -O0.
function(granary_test path)
  cmake_parse_arguments(ARG "" "TIMEOUT" "LINKS;LABELS;SOURCES;DEPENDS" ${ARGN})
  cmake_path(GET path PARENT_PATH folder)
  cmake_path(GET path FILENAME file)
  string(REPLACE "/" "." name ${path})
  set(program ${name})
  if(CMAKE_UNITY_BUILD)
    string(REPLACE "/" "." program ${folder}/tests)
  endif()
  if(NOT TARGET ${program})
    add_executable(${program})
    granary_compile_options(${program})
    if(NOT GRANARY_TESTS_AT)
      set(GRANARY_TESTS_AT -O1)
    endif()
    target_compile_options(${program} PRIVATE $<$<CONFIG:Release>:${GRANARY_TESTS_AT}>)
    set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    target_compile_definitions(${program} PRIVATE
      GRANARY_SOURCE_DIR="${CMAKE_SOURCE_DIR}" GRANARY_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
    target_link_libraries(${program} PRIVATE granary_test_main)
  endif()
  target_sources(${program} PRIVATE ${CMAKE_SOURCE_DIR}/tests/${path}.cpp ${ARG_SOURCES})
  target_link_libraries(${program} PRIVATE ${ARG_LINKS})
  if(ARG_DEPENDS)
    add_dependencies(${program} ${ARG_DEPENDS})
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_test(NAME ${name} COMMAND ${program} ${file})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
endfunction()
