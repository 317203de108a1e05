#include "scene/import/ptx.h"

#include "scene/errors.h"
#include "scene/import/local_origin.h"
#include "scene/import/scan_name.h"
#include "scene/import/text_lines.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <iomanip>
#include <limits>
#include <set>
#include <sstream>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {
namespace {

constexpr std::uint64_t kShortestPointBytes = 6; ///< "0 0 0\n"
/// Six decimals are usual and three do occur; beyond this it is no rotation.
constexpr double kPtxRotationTolerance = 2e-3;
constexpr double kToldScale = 1e-5; ///< six decimals give no more than a tenth of it by themselves

const char* const kExportAgain = "export the scan again";

struct PtxHeader {
    int rows = 0, columns = 0;
    Pose worldFromScanner;
    glm::dvec3 scannerInPoints{0.0};
    double givenScale = 1.0; ///< as the transform has it
    double scale = 1.0;      ///< pInScanner = scale * (p - scannerInPoints)
};

int parseCount(std::string_view text, const std::string& where, const char* what) {
    std::array<double, 1> number{};
    if (parseNumbers(text, number) != 1 || !(number[0] >= 0) || number[0] != std::floor(number[0]) ||
        number[0] > std::numeric_limits<int>::max())
        throw Failure(std::string("should hold the number of ") + what + "; this is not a PTX file", where,
                      "name a scan in E57 or PTX");
    return static_cast<int>(number[0]);
}

template <std::size_t N>
std::array<double, N> parseRow(TextLines& lines, const std::filesystem::path& path) {
    std::array<double, N> row{};
    std::string_view text;
    if (!lines.next(text)) throw Failure("ends within the header of a cloud", path, kExportAgain);
    const bool good = parseNumbers(text, row) == static_cast<int>(N) &&
                      std::all_of(row.begin(), row.end(), [](double v) { return std::isfinite(v); });
    if (!good) throw Failure("should hold " + std::to_string(N) + " finite numbers", lines.where(), kExportAgain);
    return row;
}

// The 4 x 4 as a rigid motion and a uniform scale.
void settleTransform(const glm::dmat4& worldFromPoints, const glm::dvec3& scannerInWorld, const std::string& where,
                     PtxHeader& header) {
    glm::dmat4 rigid = worldFromPoints;
    header.scale = std::cbrt(glm::determinant(glm::dmat3(worldFromPoints)));
    if (std::isfinite(header.scale) && header.scale > 0)
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                rigid[c][r] /= header.scale;
    if (!poseFromMatrix(rigid, kPtxRotationTolerance, header.worldFromScanner))
        throw Failure("the transform that ends here does not turn and move its cloud but bends it", where,
                      "export the scan with a rigid registration");
    header.givenScale = header.scale;
    if (std::abs(header.scale - 1.0) < kPtxRotationTolerance) header.scale = 1.0;
    const bool pointsAreInWorld = worldFromPoints == glm::dmat4(1.0) && scannerInWorld != glm::dvec3(0.0);
    if (!pointsAreInWorld) return;
    header.scannerInPoints = scannerInWorld;
    header.worldFromScanner.translation = scannerInWorld;
}

// Reads a header; false if nothing but blank lines is left.
bool readHeader(TextLines& lines, const std::filesystem::path& path, PtxHeader& header) {
    std::string_view text;
    do {
        if (!lines.next(text)) return false;
    } while (text.find_first_not_of(" \t") == std::string_view::npos);
    header = {};
    header.columns = parseCount(text, lines.where(), "columns");
    if (!lines.next(text)) throw Failure("ends within the header of a cloud", path, kExportAgain);
    header.rows = parseCount(text, lines.where(), "rows");

    const auto place = parseRow<3>(lines, path);
    for (int axis = 0; axis < 3; ++axis)
        parseRow<3>(lines, path); // the axes stand in the 4 x 4 as well
    glm::dmat4 worldFromPoints(1.0);
    // A row of the file acts from the right on row vectors: for our column vectors it is a column.
    for (int column = 0; column < 4; ++column) {
        const auto row = parseRow<4>(lines, path);
        worldFromPoints[column] = glm::dvec4(row[0], row[1], row[2], row[3]);
    }
    settleTransform(worldFromPoints, {place[0], place[1], place[2]}, lines.where(), header);
    return true;
}

std::int64_t cellsOf(const PtxHeader& header) {
    return static_cast<std::int64_t>(header.rows) * static_cast<std::int64_t>(header.columns);
}

void proveCount(const PtxHeader& header, const TextLines& lines) {
    const std::uint64_t left = lines.fileBytes() - std::min(lines.fileBytes(), lines.byte());
    if (static_cast<std::uint64_t>(cellsOf(header)) > (left + 1) / kShortestPointBytes)
        throw Failure("the cloud that begins here claims " + std::to_string(cellsOf(header)) +
                          " points, more than the bytes left can hold",
                      lines.where(), kExportAgain);
}

// Grey from intensity: 0..1 as the format has it, else whatever range was observed.
void colourByIntensity(const std::vector<float>& intensities, Scan& scan) {
    float lowest = 0, highest = 1;
    for (const float intensity : intensities)
        if (std::isfinite(intensity)) lowest = std::min(lowest, intensity), highest = std::max(highest, intensity);
    for (std::size_t i = 0; i < intensities.size(); ++i) {
        if (scan.hasColourAt(i)) continue;
        const float unit = (intensities[i] - lowest) / (highest - lowest);
        const auto grey =
            std::isfinite(unit) ? static_cast<std::uint8_t>(std::lround(unit * 255.0f)) : std::uint8_t{128};
        scan.colours[i] = {grey, grey, grey};
    }
}

std::uint8_t colourByte(double value) {
    return std::isfinite(value) ? static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)) : std::uint8_t{128};
}

// Clouds whose transforms scale and were all treated alike; the first by its number, counted from 1.
struct Scaled {
    int first = 0, count = 0;
    double scale = 1.0;

    void add(int cloud, double by) {
        if (count++ == 0) first = cloud, scale = by;
    }
    void tell(const std::filesystem::path& path, const char* whatBecameOfIt, std::vector<std::string>& remarks) const {
        if (count == 0) return;
        std::ostringstream by;
        by << std::setprecision(8) << scale;
        remarks.push_back(path.string() + ": the transform of cloud " + std::to_string(first) + " scales it by " +
                          by.str() + (count > 1 ? ", those of " + std::to_string(count - 1) + " more scale, too" : "") +
                          "; " + whatBecameOfIt + ".");
    }
};

// The points of one cloud as its lines bring them.
class Cloud {
  public:
    Cloud(const PtxHeader& header, Scan& scan) : header_(header), scan_(scan), points_(scan.pointsInScanner) {}

    void add(std::int64_t cell, std::span<const double> numbers) {
        if (numbers[0] == 0 && numbers[1] == 0 && numbers[2] == 0) return; // no return
        const glm::dvec3 p = header_.scale * (glm::dvec3(numbers[0], numbers[1], numbers[2]) - header_.scannerInPoints);
        if (!(std::abs(p.x) < FLT_MAX && std::abs(p.y) < FLT_MAX && std::abs(p.z) < FLT_MAX)) {
            ++scan_.invalidPoints;
            return;
        }
        const bool hasRgb = numbers.size() >= 6;
        const std::size_t rgb = numbers.size() == 6 ? 3 : 4;
        scan_.hasColour |= hasRgb;
        scan_.isColoured.push_back(hasRgb);
        scan_.colours.push_back(
            hasRgb ? Rgb8{colourByte(numbers[rgb]), colourByte(numbers[rgb + 1]), colourByte(numbers[rgb + 2])}
                   : Rgb8{128, 128, 128});
        const bool hasIntensity = numbers.size() == 4 || numbers.size() == 7;
        intensities_.push_back(hasIntensity ? static_cast<float>(numbers[3]) : NAN);
        scan_.row.push_back(static_cast<std::int32_t>(cell % header_.rows));
        scan_.column.push_back(static_cast<std::int32_t>(cell / header_.rows));
        points_.add(p);
    }

    void finish() {
        const std::optional<glm::dvec3> origin = points_.finish();
        scan_.settleColours();
        if (!scan_.hasColour || !scan_.isColoured.empty()) colourByIntensity(intensities_, scan_);
        scan_.rows = header_.rows;
        scan_.columns = header_.columns;
        if (!origin) return;
        scan_.worldFromScanner.translation = scan_.worldFromScanner * *origin;
        scan_.rows = scan_.columns = 0;
        scan_.row = {};
        scan_.column = {};
    }

  private:
    const PtxHeader& header_;
    Scan& scan_;
    PointsAboutOrigin points_;
    std::vector<float> intensities_;
};

} // namespace

std::vector<ScanSource> listPtx(const std::filesystem::path& path, std::vector<std::string>& remarks) {
    TextLines lines(path, 0);
    std::vector<ScanSource> sources;
    Scaled applied, leftOut;
    PtxHeader header;
    for (std::uint64_t start = 0; readHeader(lines, path, header); start = lines.byte()) {
        proveCount(header, lines);
        ScanSource source;
        source.path = path;
        source.format = ScanFormat::ptx;
        source.indexInFile = static_cast<int>(sources.size());
        source.byteInFile = start;
        source.worldFromScanner = header.worldFromScanner;
        source.pointCount = cellsOf(header);
        source.rows = header.rows;
        source.columns = header.columns;
        sources.push_back(source);
        if (std::abs(header.givenScale - 1.0) > kToldScale)
            (header.scale == 1.0 ? leftOut : applied).add(static_cast<int>(sources.size()), header.givenScale);
        const auto cells = static_cast<std::uint64_t>(source.pointCount);
        if (const std::uint64_t found = lines.skip(cells); found < cells)
            throw Failure("ends after " + std::to_string(found) + " of the " + std::to_string(cells) +
                              " points of cloud " + std::to_string(sources.size()),
                          lines.where(), kExportAgain);
    }
    if (sources.empty()) throw Failure("is empty", path, "name a scan in E57 or PTX");
    applied.tell(path, "its points were scaled", remarks);
    leftOut.tell(path, "that may be rounding, and its points were left as they are", remarks);
    std::set<std::string> names;
    for (ScanSource& source : sources) {
        const std::string number = sources.size() > 1 ? "-" + std::to_string(source.indexInFile + 1) : std::string();
        source.name = scanName(path.stem().string() + number, "scan", names);
    }
    return sources;
}

Scan readPtxScan(const ScanSource& source) {
    Scan scan;
    scan.name = source.name;
    TextLines lines(source.path, source.byteInFile);
    PtxHeader header;
    if (!readHeader(lines, source.path, header))
        throw Failure("has no cloud here any more", lines.where(), "read it again: it has changed");
    proveCount(header, lines);
    scan.worldFromScanner = header.worldFromScanner;

    Cloud cloud(header, scan);
    std::array<double, 7> numbers{};
    std::string_view text;
    const std::int64_t cells = cellsOf(header);
    for (std::int64_t cell = 0; cell < cells; ++cell) {
        if (!lines.next(text))
            throw Failure("ends after " + std::to_string(cell) + " of " + std::to_string(cells) + " points",
                          lines.where(), kExportAgain);
        const int count = parseNumbers(text, numbers);
        if (count < 3 || count == 5 || count > 7)
            throw Failure("should hold x y z, an intensity and a colour", lines.where(), kExportAgain);
        cloud.add(cell, std::span(numbers).first(static_cast<std::size_t>(count)));
    }
    cloud.finish();
    return scan;
}

} // namespace scene
