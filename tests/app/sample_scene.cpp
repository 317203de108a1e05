#include "tests/app/sample_scene.h"

#include "tests/app/made_sample.h"
#include "tests/app/program.h"

#include <stdexcept>

namespace app {

namespace {

void runOrThrow(const std::vector<std::string>& command, const std::filesystem::path& scratch) {
    const Outcome outcome = run(command, scratch);
    if (outcome.status != 0) throw std::runtime_error(command[0] + " failed:\n" + outcome.output);
}

} // namespace

void prepare(const std::string& capture, const std::string& scene, const std::filesystem::path& scratch,
             const std::vector<std::string>& options) {
    std::vector<std::string> command{REVISIT_PROGRAM, "build", capture, "-o", scene};
    command.insert(command.end(), options.begin(), options.end());
    runOrThrow(command, scratch);
}

SampleScene::SampleScene(const std::string& kind, int images, const std::string& size) {
    const Outcome made =
        makeSample({capture(), "--scene", kind, "--images", std::to_string(images), "--size", size}, folder_.path());
    if (made.status != 0) throw std::runtime_error("make_sample failed:\n" + made.output);
    prepare(capture(), scene(), folder_.path(), {});
}

} // namespace app
