# The libraries we take instead of writing them (ARCHITECTURE.md lists why each is here).
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(TIFF REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(Ceres 2 REQUIRED)
find_package(Vulkan REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(embree 3 REQUIRED)
find_package(assimp 5 REQUIRED)
find_package(XercesC REQUIRED)
find_package(CGAL 5 REQUIRED)
find_package(OpenCV REQUIRED COMPONENTS core imgproc imgcodecs calib3d videoio)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(SPNG REQUIRED IMPORTED_TARGET spng)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)

pkg_check_modules(OPENXR REQUIRED IMPORTED_TARGET openxr)
pkg_check_modules(STB REQUIRED IMPORTED_TARGET stb)
find_package(glfw3 3.3 REQUIRED)
find_package(OpenGL REQUIRED COMPONENTS OpenGL)

# Dear ImGui as Debian builds it: its Vulkan backend calls Vulkan by name, where volk has variables of those names, so
# windows draw with OpenGL.
find_path(IMGUI_INCLUDE imgui.h PATH_SUFFIXES imgui REQUIRED)
find_library(IMGUI_LIBRARY imgui REQUIRED)
add_library(revisit_imgui INTERFACE)
target_include_directories(revisit_imgui SYSTEM INTERFACE ${IMGUI_INCLUDE})
target_link_libraries(revisit_imgui INTERFACE ${IMGUI_LIBRARY} PkgConfig::STB glfw OpenGL::GL)

find_program(GLSLANG glslangValidator REQUIRED)

# GLM: conventions stand once, here. SYSTEM because its half-float code warns.
find_path(GLM_INCLUDE glm/glm.hpp REQUIRED)
add_library(revisit_glm INTERFACE)
target_include_directories(revisit_glm SYSTEM INTERFACE ${GLM_INCLUDE})
target_compile_definitions(revisit_glm INTERFACE GLM_FORCE_RADIANS GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_XYZW_ONLY
    GLM_FORCE_EXPLICIT_CTOR)

# libE57Format: Debian's where it has one, else the copy that ./dev built (cmake/get_e57format.sh).
find_path(E57_INCLUDE E57SimpleReader.h PATHS ${REVISIT_DEPS}/e57format/include PATH_SUFFIXES E57Format REQUIRED)
find_library(E57_LIBRARY NAMES E57Format PATHS ${REVISIT_DEPS}/e57format/lib REQUIRED)
add_library(revisit_e57format INTERFACE)
target_include_directories(revisit_e57format SYSTEM INTERFACE ${E57_INCLUDE})
target_link_libraries(revisit_e57format INTERFACE ${E57_LIBRARY} XercesC::XercesC)
