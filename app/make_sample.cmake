# make_sample: sample captures of synthetic scenes.
add_executable(make_sample make_sample.cpp sample_scans.cpp)
target_include_directories(make_sample SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(make_sample PRIVATE scene scene_align scene_capture revisit_flags CLI11::CLI11 nlohmann_json::nlohmann_json
    opencv_core opencv_imgcodecs)
