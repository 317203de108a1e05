#include "app/output_file.h"

#include "scene/errors.h"

#include <array>
#include <fstream>

namespace app {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kOtherName = "name another file";

json jsonIn(const fs::path& file) {
    std::ifstream stream(file);
    return json::parse(stream, nullptr, false);
}

} // namespace

void checkReplaceableFile(const fs::path& file, std::span<const fs::path> inputs,
                          const std::function<bool(const json&)>& isKind) {
    std::error_code ignored;
    const fs::file_status status = fs::status(file, ignored);
    if (!fs::exists(status)) {
        if (fs::is_symlink(fs::symlink_status(file, ignored)))
            throw scene::Failure("is a link to what does not exist", file, kOtherName);
        return;
    }
    if (fs::is_directory(status)) throw scene::Failure("is a folder", file, "name the JSON file to write");
    if (!fs::is_regular_file(status)) return;
    for (const fs::path& input : inputs)
        if (fs::equivalent(file, input, ignored))
            throw scene::Failure("would be lost: this command reads it", file, kOtherName);
    if (!std::ifstream(file))
        throw scene::Failure("exists and cannot be read, so that nobody knows what would be replaced", file,
                             kOtherName);
    if (fs::file_size(file, ignored) > 0 && !isKind(jsonIn(file)))
        throw scene::Failure("exists and is nothing that this command writes", file, kOtherName);
}

json reportIn(const fs::path& folder, const std::function<bool(const json&)>& isKind) {
    json report = jsonIn(folder / "report.json");
    return report.is_object() && isKind(report) ? report : json();
}

void checkReplaceableReport(const fs::path& folder, const std::function<bool(const json&)>& isKind) {
    checkReplaceableBeside(folder, isKind, std::array<std::string, 1>{"report.json"});
}

void checkReplaceableBeside(const fs::path& folder, const std::function<bool(const json&)>& isKind,
                            std::span<const std::string> names) {
    if (!reportIn(folder, isKind).is_null()) return;
    std::error_code ignored;
    for (const std::string& name : names)
        if (fs::exists(fs::symlink_status(folder / name, ignored)))
            throw scene::Failure("holds " + name +
                                     ", which no finished run of this command wrote and which would be "
                                     "replaced",
                                 folder, "name another folder with --out");
}

std::vector<std::string> picturesIn(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code ignored;
    for (fs::directory_iterator at(folder, ignored), end; !ignored && at != end; at.increment(ignored)) {
        const std::string extension = at->path().extension().string();
        if (extension == ".png" || extension == ".tiff") names.push_back(at->path().filename().string());
    }
    return names;
}

bool isDrawnReport(const json& report) {
    return report.is_object() && report.contains("samples_drawn") && report.contains("frames");
}

} // namespace app
