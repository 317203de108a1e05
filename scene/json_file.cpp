#include "scene/json_file.h"

#include "scene/errors.h"

#include <fstream>
#include <string>

namespace scene {

using nlohmann::json;

json readJsonFile(const std::filesystem::path& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw Failure("is a folder", path, "name a file");
    std::ifstream file(path);
    if (!file) throw Failure("no such file", path, "check the path");
    try {
        return json::parse(file);
    } catch (const json::parse_error& e) {
        throw Failure("is not valid JSON", atByte(path, e.byte), "repair it there");
    } catch (const json::exception& e) { // a number that no double can hold
        throw Failure(std::string("has a number that cannot be used (") + e.what() + ")", path, "correct it");
    }
}

} // namespace scene
