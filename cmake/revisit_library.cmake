# revisit_library(name SOURCES ... LINKS ... PRIVATE_LINKS ...): a static library of ours.
# LINKS are the arrows between folders (tests/arrows.cmake checks that the #include lines agree).
function(revisit_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE revisit_flags ${ARG_PRIVATE_LINKS})
endfunction()
