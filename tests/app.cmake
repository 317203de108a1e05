# The programs, run as a user would.
function(revisit_program_test name)
    revisit_test(${name} ${ARGN} LINKS nlohmann_json::nlohmann_json opencv_core opencv_imgcodecs)
    target_compile_definitions(${name} PRIVATE REVISIT_PROGRAM="$<TARGET_FILE:revisit>"
        REVISIT_MAKE_SAMPLE="$<TARGET_FILE:make_sample>" REVISIT_KEPT_SAMPLES="${CMAKE_BINARY_DIR}/samples")
    target_sources(${name} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/app/made_sample.cpp)
    target_include_directories(${name} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
    # They spend their time waiting for the programs; so they are compiled in two thirds of it.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    add_dependencies(${name} revisit make_sample)
endfunction()

# From a capture to frames.
revisit_program_test(revisit_app_tests WHOLE LABELS programs TIMEOUT 600
    SOURCES app/comparison.cpp app/memory_test.cpp app/outputs_test.cpp app/program.cpp app/sample_scene.cpp app/walk_test.cpp)

# Settings against photographs and the clock.
revisit_program_test(revisit_measure_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/measure_test.cpp app/program.cpp)

# Where the next scans should stand.
revisit_program_test(revisit_plan_program_tests LABELS programs
    SOURCES app/plan_test.cpp app/program.cpp)
target_link_libraries(revisit_plan_program_tests PRIVATE scene)

# Laser scans, from the simulated scanner to where they stand.
revisit_program_test(revisit_scans_program_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/program.cpp app/scans_test.cpp scene/import/written_e57.cpp)
target_link_libraries(revisit_scans_program_tests PRIVATE scene scene_align revisit_e57format)

# Photographs with range, whose poses are put right.
revisit_program_test(revisit_poses_program_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/poses_test.cpp app/program.cpp)
target_link_libraries(revisit_poses_program_tests PRIVATE scene)

# Photographs beside scans, from the simulated camera to how they lie on them.
revisit_program_test(revisit_photographs_program_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/photographs_test.cpp app/program.cpp)
target_link_libraries(revisit_photographs_program_tests PRIVATE scene)

# Instruments that are a little off.
revisit_program_test(revisit_instruments_tests LABELS programs
    SOURCES app/comparison.cpp app/instruments_test.cpp app/program.cpp)
target_link_libraries(revisit_instruments_tests PRIVATE scene)

# From raw scans and photographs to pictures.
revisit_program_test(revisit_chain_tests LABELS programs TIMEOUT 600
    SOURCES app/chain_test.cpp app/comparison.cpp app/program.cpp)
target_link_libraries(revisit_chain_tests PRIVATE scene)

# Captures of others, once and whole.
revisit_program_test(revisit_captures_tests LABELS data programs TIMEOUT 600
    SOURCES app/captures_test.cpp app/comparison.cpp app/program.cpp)

# Polygons, from files to frames.
revisit_program_test(revisit_polygons_build_tests LABELS data programs TIMEOUT 300
    SOURCES app/comparison.cpp app/polygons_build_test.cpp app/program.cpp app/written_room.cpp)
target_link_libraries(revisit_polygons_build_tests PRIVATE scene_capture)

revisit_program_test(revisit_degenerate_positions_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/degenerate_positions_test.cpp app/program.cpp app/written_room.cpp)
target_link_libraries(revisit_degenerate_positions_tests PRIVATE scene_plan)

# Walk cells, and positions that choose themselves.
revisit_program_test(revisit_cells_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/cells_test.cpp app/comparison.cpp app/program.cpp)
target_link_libraries(revisit_cells_tests PRIVATE scene_plan)

# What the world may do to the programs; and an image from its own place.
revisit_program_test(revisit_world_tests LABELS programs
    SOURCES app/comparison.cpp app/full_disk_test.cpp app/itself_test.cpp app/no_device_test.cpp app/program.cpp)

# Devices that fail, made so by a layer between the programs and the driver.
add_library(revisit_faulty_layer MODULE app/faulty_layer.cpp)
target_link_libraries(revisit_faulty_layer PRIVATE revisit_flags)
target_include_directories(revisit_faulty_layer SYSTEM PRIVATE ${Vulkan_INCLUDE_DIRS})
# It goes on counting when the loader has closed it and opens it again for another device.
target_link_options(revisit_faulty_layer PRIVATE -Wl,-z,nodelete)
set(faulty_layer ${CMAKE_CURRENT_BINARY_DIR}/faulty_layer)
file(GENERATE OUTPUT ${faulty_layer}/faulty.json CONTENT "{\"file_format_version\": \"1.2.0\", \"layer\": {
    \"name\": \"VK_LAYER_REVISIT_faulty\", \"type\": \"GLOBAL\", \"library_path\": \"$<TARGET_FILE:revisit_faulty_layer>\",
    \"api_version\": \"1.3.0\", \"implementation_version\": \"1\", \"description\": \"A faulty device, for tests\"}}
")
target_compile_definitions(revisit_app_tests PRIVATE REVISIT_FAULTY_LAYER="${faulty_layer}")
add_dependencies(revisit_app_tests revisit_faulty_layer)
revisit_program_test(revisit_faulty_device_tests WHOLE LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/faulty_device_test.cpp app/program.cpp app/sample_scene.cpp)
target_compile_definitions(revisit_faulty_device_tests PRIVATE REVISIT_FAULTY_LAYER="${faulty_layer}")
add_dependencies(revisit_faulty_device_tests revisit_faulty_layer)

# What the programs are made of.
revisit_test(revisit_app_unit_tests WHOLE LABELS unit LINKS app CLI11::CLI11 nlohmann_json::nlohmann_json
    SOURCES app/annotate_test.cpp app/coverage_on_device_test.cpp app/desk_test.cpp app/governor_test.cpp app/kept_settings_test.cpp app/measure_table_test.cpp
        app/note_accuracy_test.cpp app/notes_test.cpp scene/known_scenes.cpp app/output_file_test.cpp app/overlays_test.cpp
        app/picture_error_test.cpp app/positions_test.cpp app/quality_file_test.cpp app/real_range_test.cpp
        app/scan_agreement_test.cpp app/scene_folder_test.cpp app/selection_test.cpp app/spread_test.cpp app/stage_store_test.cpp app/view_files_test.cpp app/walk_record_test.cpp)

# The window, with real keys, on a screen without a monitor.
find_package(X11 REQUIRED)
revisit_program_test(revisit_desktop_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/desktop_test.cpp app/program.cpp app/screen.cpp)
target_link_libraries(revisit_desktop_tests PRIVATE X11::X11)
target_compile_definitions(revisit_desktop_tests PRIVATE REVISIT_FAULTY_LAYER="${faulty_layer}")
add_dependencies(revisit_desktop_tests revisit_faulty_layer)
