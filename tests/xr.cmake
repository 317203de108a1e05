# The headset through a real runtime: Monado, its head and controllers steered by the test (tests/xr/monado.h).
add_library(revisit_monado STATIC xr/monado.cpp xr/remote_head.cpp)
target_include_directories(revisit_monado PUBLIC ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_monado PUBLIC scene PRIVATE revisit_flags)
target_compile_definitions(revisit_monado PRIVATE REVISIT_MONADO="${REVISIT_DEPS}/monado")

# A runtime that refuses, loses and forgets what Monado never does; it has Vulkan's functions to itself.
add_library(revisit_fake_volk STATIC ${VOLK_SOURCE})
target_include_directories(revisit_fake_volk SYSTEM PUBLIC ${VOLK_INCLUDE} ${Vulkan_INCLUDE_DIRS})
add_library(revisit_fake_runtime MODULE xr/fake_runtime.cpp)
set_target_properties(revisit_fake_volk revisit_fake_runtime PROPERTIES POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden C_VISIBILITY_PRESET hidden)
target_include_directories(revisit_fake_runtime SYSTEM PRIVATE ${OPENXR_INCLUDE_DIRS})
target_link_libraries(revisit_fake_runtime PRIVATE revisit_fake_volk revisit_flags ${CMAKE_DL_LIBS})

# In this process, frame by frame.
revisit_test(revisit_headset_tests LABELS gpu LINKS revisit_monado revisit_render_scenes xr
    SOURCES xr/fake.cpp xr/fake_headset_test.cpp xr/headset_rig.cpp xr/headset_test.cpp xr/visibility_mask_test.cpp)
target_compile_definitions(revisit_headset_tests PRIVATE REVISIT_FAKE_RUNTIME="$<TARGET_FILE:revisit_fake_runtime>")
add_dependencies(revisit_headset_tests revisit_fake_runtime)
revisit_test(revisit_controllers_tests LABELS programs LINKS app revisit_monado nlohmann_json::nlohmann_json
    SOURCES app/made_sample.cpp app/program.cpp xr/controllers_test.cpp)
target_compile_definitions(revisit_controllers_tests PRIVATE REVISIT_PROGRAM="$<TARGET_FILE:revisit>"
    REVISIT_MAKE_SAMPLE="$<TARGET_FILE:make_sample>" REVISIT_KEPT_SAMPLES="${CMAKE_BINARY_DIR}/samples")
add_dependencies(revisit_controllers_tests revisit make_sample)

# The walk, run as a user would.
revisit_program_test(revisit_headset_walk_tests LABELS data programs TIMEOUT 400
    SOURCES app/comparison.cpp app/program.cpp app/sample_scene.cpp app/walker.cpp xr/headset_walk_test.cpp)
target_link_libraries(revisit_headset_walk_tests PRIVATE revisit_monado scene)

# What may happen on the way.
revisit_program_test(revisit_headset_world_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/program.cpp app/sample_scene.cpp app/walker.cpp xr/bad_runtime_test.cpp xr/fake.cpp xr/long_walk_test.cpp
        xr/lost_device_test.cpp xr/runtime_dies_test.cpp)
target_link_libraries(revisit_headset_world_tests PRIVATE revisit_monado scene)
target_compile_definitions(revisit_headset_world_tests PRIVATE REVISIT_FAKE_RUNTIME="$<TARGET_FILE:revisit_fake_runtime>"
    REVISIT_FAULTY_LAYER="${faulty_layer}")
add_dependencies(revisit_headset_world_tests revisit_fake_runtime revisit_faulty_layer)

# A window beside the headset.
revisit_program_test(revisit_desk_fallback_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/program.cpp app/sample_scene.cpp app/screen.cpp app/walker.cpp xr/desk_fallback_test.cpp)
target_link_libraries(revisit_desk_fallback_tests PRIVATE revisit_monado scene X11::X11)
