# revisit_library(name SOURCES ... LINKS ... PRIVATE_LINKS ...): a static library of ours.
# LINKS are the arrows between folders (tests/arrows.cmake checks that the #include lines agree).
function(revisit_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    # Highway compiles these several times over by including them; they cannot share a unit with others.
    set(vectors ${ARG_SOURCES})
    list(FILTER vectors INCLUDE REGEX "_simd\\.cpp$")
    set_source_files_properties(${vectors} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE revisit_flags ${ARG_PRIVATE_LINKS})
endfunction()

# revisit_late_library(name SOURCE LINKS ...): a library of ours that programs load when they first need it
# (scene/late_library.h), which they find in their run path.
function(revisit_late_library name source)
    cmake_parse_arguments(ARG "" "" "LINKS" ${ARGN})
    add_library(${name} MODULE ${source})
    target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
    target_include_directories(${name} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
    target_link_libraries(${name} PRIVATE revisit_flags ${ARG_LINKS})
    set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_ARCHIVE_OUTPUT_DIRECTORY})
endfunction()
