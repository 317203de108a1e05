#pragma once
// E57 files for tests: written with libE57Format, and taken apart and put together again where a test wants
// them wrong.

#include "scene/pose.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scene {

/// A folder that is gone when the test is over.
class TemporaryFolder {
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  private:
    std::filesystem::path path_;
};

enum class NumberType { float32, float64, integer, scaled };

/// A field of the points. minimum and maximum bound integers, and scaled ones before scaling.
struct WrittenField {
    std::string name;
    NumberType type = NumberType::float64;
    std::vector<double> values;
    std::int64_t minimum = 0, maximum = 0;
    double scale = 1, offset = 0;
};

struct WrittenNumber {
    std::string name;
    double value = 0;
};

struct WrittenPose {
    double w = 1, x = 0, y = 0, z = 0, tx = 0, ty = 0, tz = 0;
};

struct WrittenScan {
    std::string name;
    std::optional<WrittenPose> pose;
    std::vector<WrittenField> fields{};
    std::vector<WrittenNumber> indexBounds{}, colorLimits{}, intensityLimits{};
};

struct WrittenImage {
    std::string name, representation; ///< such as "pinholeRepresentation"
    std::optional<WrittenPose> pose;
    std::vector<WrittenNumber> numbers;
    std::vector<std::uint8_t> jpeg;
};

void writeE57(const std::filesystem::path& path, const std::vector<WrittenScan>& scans,
              const std::vector<WrittenImage>& images = {});

/// Three double fields cartesianX, Y, Z.
std::vector<WrittenField> cartesian(const std::vector<double>& x, const std::vector<double>& y,
                                    const std::vector<double>& z);

std::string readBytes(const std::filesystem::path& path);
void writeBytes(const std::filesystem::path& path, const std::string& bytes);

/// A file's content without its checksums, and back with right ones: damage that no checksum tells.
std::string withoutChecksums(const std::string& fileBytes);
std::string withChecksums(const std::string& content);

/// The file with its XML section replaced, all sizes and checksums right again.
std::string withXml(const std::string& fileBytes, const std::function<std::string(std::string)>& change);

/// text with the first `from` replaced; fails the test if there is none.
std::string replaced(std::string text, const std::string& from, const std::string& to);

} // namespace scene
