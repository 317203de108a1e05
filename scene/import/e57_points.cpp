#include "scene/import/e57.h"

#include "scene/errors.h"
#include "scene/import/e57_file.h"
#include "scene/import/local_origin.h"

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace scene {
namespace {

constexpr std::size_t kBlockPoints = 1 << 16;
// Constant fields take no bits, so a list whose coordinates are constant may claim very many points for few
// bytes. They all stand at one place; this many are believed.
constexpr std::int64_t kMaxPointsWithoutBytes = 1 << 16;
// A grid with more cells than this for each point is not a scanner's grid but a damaged index.
constexpr std::int64_t kMaxCellsPerPoint = 64, kAlwaysPlausibleCells = 1 << 22;

const char* const kPointsDamaged = "copy or export the scan again";

enum Field {
    kX,
    kY,
    kZ,
    kInvalid,
    kRed,
    kGreen,
    kBlue,
    kColourInvalid,
    kIntensity,
    kIntensityInvalid,
    kRow,
    kColumn,
    kFieldCount
};

struct Limits {
    double minimum = 0, maximum = 0;
    bool known() const { return maximum > minimum; }
    double unit(double value) const {
        const double u = known() ? (value - minimum) / (maximum - minimum) : 0.5;
        return std::isfinite(u) ? std::clamp(u, 0.0, 1.0) : 0.5;
    }
};

std::uint8_t to8Bit(double unit) {
    return static_cast<std::uint8_t>(std::lround(unit * 255.0));
}

struct RecordBits {
    std::int64_t all = 0, position = 0;
};

// What one record takes at least, in bits.
RecordBits bitsOf(const e57::StructureNode& prototype) {
    RecordBits sum;
    const auto integerBits = [](std::int64_t minimum, std::int64_t maximum) {
        return static_cast<std::int64_t>(
            std::bit_width(static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum)));
    };
    for (std::int64_t i = 0; i < prototype.childCount(); ++i) {
        const e57::Node node = prototype.get(i);
        std::int64_t bits = 0;
        switch (node.type()) {
        case e57::E57_INTEGER:
            bits = integerBits(e57::IntegerNode(node).minimum(), e57::IntegerNode(node).maximum());
            break;
        case e57::E57_SCALED_INTEGER:
            bits = integerBits(e57::ScaledIntegerNode(node).minimum(), e57::ScaledIntegerNode(node).maximum());
            break;
        case e57::E57_FLOAT:
            bits = e57::FloatNode(node).precision() == e57::E57_SINGLE ? 32 : 64;
            break;
        case e57::E57_STRING:
            bits = 8; // the length of the shortest
            break;
        default:
            break; // a nested structure: its fields are not counted, and the bound stays a bound
        }
        sum.all += bits;
        if (node.elementName().starts_with("cartesian") || node.elementName().starts_with("spherical"))
            sum.position += bits;
    }
    return sum;
}

void proveCount(std::int64_t count, const RecordBits& bits, std::uint64_t fileBytes, const ScanSource& source) {
    const std::string claim = "scan '" + source.name + "' claims " + std::to_string(count) + " points";
    if (count < 0) throw Failure(claim, source.path, kPointsDamaged);
    if (count > 0 && bits.all == 0) throw Failure(claim + " and holds no byte for them", source.path, kPointsDamaged);
    if (bits.position == 0 && count > kMaxPointsWithoutBytes)
        throw Failure(claim + " at one place", source.path, kPointsDamaged);
    if (bits.all > 0 && static_cast<std::uint64_t>(count) > fileBytes * 8 / static_cast<std::uint64_t>(bits.all)) {
        throw Failure(claim + ", more than its " + std::to_string(fileBytes) + " bytes can hold", source.path,
                      kPointsDamaged);
    }
}

// The limits a field declares of itself, where they are those of a measured value and not of its number type.
Limits ownLimits(const e57::StructureNode& prototype, const char* name) {
    const auto node = childOf(prototype, name);
    Limits limits;
    if (!node) return limits;
    if (node->type() == e57::E57_INTEGER)
        limits = {static_cast<double>(e57::IntegerNode(*node).minimum()),
                  static_cast<double>(e57::IntegerNode(*node).maximum())};
    else if (node->type() == e57::E57_SCALED_INTEGER)
        limits = {e57::ScaledIntegerNode(*node).scaledMinimum(), e57::ScaledIntegerNode(*node).scaledMaximum()};
    else if (node->type() == e57::E57_FLOAT)
        limits = {e57::FloatNode(*node).minimum(), e57::FloatNode(*node).maximum()};
    return limits.maximum - limits.minimum < FLT_MAX / 2 ? limits : Limits{};
}

Limits limitsOf(const e57::StructureNode& scan, const char* group, const std::string& name) {
    const auto node = childOf(scan, group);
    if (!node || node->type() != e57::E57_STRUCTURE) return {};
    const e57::StructureNode limits(*node);
    const auto minimum = numberOf(limits, name + "Minimum"), maximum = numberOf(limits, name + "Maximum");
    if (!minimum || !maximum || !std::isfinite(*minimum) || !std::isfinite(*maximum)) return {};
    return {*minimum, *maximum};
}

// Reads a scan's records block by block into doubles, one array for each field that is there.
class Records {
  public:
    Records(e57::ImageFile& file, const e57::CompressedVectorNode& points) {
        const e57::StructureNode prototype(points.prototype());
        const auto ofBlock = static_cast<std::size_t>(
            std::clamp<std::int64_t>(points.childCount(), 1, static_cast<std::int64_t>(kBlockPoints)));
        const auto take = [&](Field field, const char* name) {
            const auto node = childOf(prototype, name);
            if (!node || values_[field].size()) return;
            const bool isNumber = node->type() == e57::E57_INTEGER || node->type() == e57::E57_SCALED_INTEGER ||
                                  node->type() == e57::E57_FLOAT;
            if (!isNumber) return;
            values_[field].resize(ofBlock);
            buffers_.emplace_back(file, name, values_[field].data(), ofBlock, true, true);
        };
        take(kX, "cartesianX");
        take(kY, "cartesianY");
        take(kZ, "cartesianZ");
        take(kInvalid, "cartesianInvalidState");
        spherical = !has(kX) || !has(kY) || !has(kZ);
        if (spherical) {
            buffers_.clear();
            for (auto& values : values_)
                values.clear();
            take(kX, "sphericalRange");
            take(kY, "sphericalAzimuth");
            take(kZ, "sphericalElevation");
            take(kInvalid, "sphericalInvalidState");
        }
        take(kRed, "colorRed");
        take(kGreen, "colorGreen");
        take(kBlue, "colorBlue");
        take(kColourInvalid, "isColorInvalid");
        take(kIntensity, "intensity");
        take(kIntensityInvalid, "isIntensityInvalid");
        take(kRow, "rowIndex");
        take(kColumn, "columnIndex");
    }

    bool has(Field field) const { return !values_[field].empty(); }
    double operator()(Field field, std::size_t i) const { return values_[field][i]; }
    bool marked(Field field, std::size_t i) const { return has(field) && values_[field][i] != 0; }
    std::vector<e57::SourceDestBuffer>& buffers() { return buffers_; }

    glm::dvec3 position(std::size_t i) const {
        const glm::dvec3 p(values_[kX][i], values_[kY][i], values_[kZ][i]);
        if (!spherical) return p;
        return p.x * glm::dvec3(std::cos(p.z) * std::cos(p.y), std::cos(p.z) * std::sin(p.y), std::sin(p.z));
    }

    bool spherical = false;

  private:
    std::vector<double> values_[kFieldCount];
    std::vector<e57::SourceDestBuffer> buffers_;
};

// The colour of a scan's points, or their brightness until the observed range is known.
class Colours {
  public:
    Colours(const e57::StructureNode& scan, const e57::StructureNode& prototype, const Records& records,
            bool wantsIntensity)
        : hasColour(records.has(kRed) && records.has(kGreen) && records.has(kBlue)),
          hasIntensity_((wantsIntensity || !hasColour || records.has(kColourInvalid)) && records.has(kIntensity)),
          intensity_(limitsOf(scan, "intensityLimits", "intensity")) {
        const char* const limitNames[] = {"colorRed", "colorGreen", "colorBlue"};
        for (int c = 0; c < 3; ++c) {
            channels_[c] = limitsOf(scan, "colorLimits", limitNames[c]);
            if (!channels_[c].known()) channels_[c] = ownLimits(prototype, limitNames[c]);
        }
    }

    // Without declared limits the largest value of the first block with coloured points tells floats of 0..1, bytes
    // and 16 bit numbers apart. What writers leave in records that are marked invalid tells nothing.
    void guessLimits(const Records& records, std::span<const std::size_t> valid) {
        if (!hasColour || isGuessed_) return;
        double largest = 0;
        for (const std::size_t i : valid) {
            if (records.marked(kColourInvalid, i)) continue;
            isGuessed_ = true;
            for (const Field field : {kRed, kGreen, kBlue})
                if (std::isfinite(records(field, i))) largest = std::max(largest, records(field, i));
        }
        if (!isGuessed_) return;
        for (Limits& channel : channels_)
            if (!channel.known()) channel = {0.0, largest <= 1.0 ? 1.0 : largest <= 255.0 ? 255.0 : 65535.0};
    }

    void add(const Records& records, std::size_t i, Scan& scan) {
        Rgb8 colour{128, 128, 128};
        const bool isColoured = hasColour && !records.marked(kColourInvalid, i);
        if (hasColour && records.has(kColourInvalid)) scan.isColoured.push_back(isColoured);
        if (isColoured)
            colour = {to8Bit(channels_[0].unit(records(kRed, i))), to8Bit(channels_[1].unit(records(kGreen, i))),
                      to8Bit(channels_[2].unit(records(kBlue, i)))};
        scan.colours.push_back(colour);
        if (!hasIntensity_) return;
        const double value = records.marked(kIntensityInvalid, i) ? NAN : records(kIntensity, i);
        brightness_.push_back(static_cast<float>(value));
        if (std::isfinite(value)) observed_ = {std::min(observed_.minimum, value), std::max(observed_.maximum, value)};
    }

    /// As the file has them; empty where it has none.
    std::vector<float> takeIntensities() { return std::move(brightness_); }

    /// Without colour a point is as bright as what came back.
    void finish(Scan& scan) const {
        if (!scan.isColoured.empty()) scan.settleColours();
        if (!hasIntensity_) return;
        const Limits& limits = intensity_.known() ? intensity_ : observed_;
        for (std::size_t i = 0; i < brightness_.size(); ++i) {
            if (scan.hasColourAt(i)) continue;
            const std::uint8_t grey = std::isfinite(brightness_[i]) ? to8Bit(limits.unit(brightness_[i])) : 128;
            scan.colours[i] = {grey, grey, grey};
        }
    }

    bool hasColour = false;

  private:
    bool hasIntensity_ = false, isGuessed_ = false;
    Limits channels_[3], intensity_;
    Limits observed_{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    std::vector<float> brightness_;
};

void forgetGrid(Scan& scan) {
    scan.rows = scan.columns = 0;
    scan.row = {};
    scan.column = {};
}

// Indices as the file has them -> counted from 0, or no grid at all where they make none.
void settleGrid(Scan& scan) {
    if (scan.row.empty()) return forgetGrid(scan);
    const auto [minRow, maxRow] = std::minmax_element(scan.row.begin(), scan.row.end());
    const auto [minColumn, maxColumn] = std::minmax_element(scan.column.begin(), scan.column.end());
    const std::int32_t row0 = *minRow, column0 = *minColumn;
    const std::int64_t rows = std::int64_t{*maxRow} - row0 + 1, columns = std::int64_t{*maxColumn} - column0 + 1;
    const std::int64_t plausible =
        std::max(kAlwaysPlausibleCells, kMaxCellsPerPoint * static_cast<std::int64_t>(scan.row.size()));
    if (rows > std::numeric_limits<std::int32_t>::max() || columns > plausible / rows) return forgetGrid(scan);
    for (std::int32_t& row : scan.row)
        row -= row0;
    for (std::int32_t& column : scan.column)
        column -= column0;
    scan.rows = static_cast<int>(rows);
    scan.columns = static_cast<int>(columns);
}

ScanWithIntensity readAs(const ScanSource& source, bool wantsIntensity) {
    ScanWithIntensity result;
    Scan& scan = result.scan;
    scan.name = source.name;
    withE57Failures(source.path, [&] {
        e57::ImageFile file = openE57(source.path);
        const e57::StructureNode node = structureAt(file, "data3D", source.indexInFile, source.path);
        scan.worldFromScanner = poseOf(node, "scan '" + source.name + "'", source.path);
        e57::CompressedVectorNode points(node.get("points"));
        const e57::StructureNode prototype(points.prototype());
        const std::int64_t count = points.childCount();
        const std::uint64_t fileBytes = std::filesystem::file_size(source.path);
        proveCount(count, bitsOf(prototype), fileBytes, source);

        Records records(file, points);
        if (!records.has(kX) || !records.has(kY) || !records.has(kZ))
            throw Failure("scan '" + source.name + "' has no coordinates", source.path, "export it with coordinates");
        Colours colours(node, prototype, records, wantsIntensity);
        scan.hasColour = colours.hasColour;
        if (count == 0) return; // some writers give such a list no bytes at all

        bool gridded = records.has(kRow) && records.has(kColumn);
        const std::size_t expected = std::min(static_cast<std::uint64_t>(count), fileBytes);
        scan.pointsInScanner.reserve(expected);
        scan.colours.reserve(expected);
        if (gridded) scan.row.reserve(expected), scan.column.reserve(expected);
        PointsAboutOrigin aboutOrigin(scan.pointsInScanner);
        std::vector<glm::dvec3> block;
        std::vector<std::size_t> valid;
        std::int64_t done = 0;
        e57::CompressedVectorReader reader = points.reader(records.buffers());
        while (const std::size_t n = reader.read()) {
            block.clear();
            valid.clear();
            for (std::size_t i = 0; i < n; ++i) {
                const glm::dvec3 p = records.position(i);
                const bool representable = glm::all(glm::lessThan(glm::abs(p), glm::dvec3(FLT_MAX))); // false for NaN
                if (records.marked(kInvalid, i) || !representable) continue;
                block.push_back(p);
                valid.push_back(i);
            }
            colours.guessLimits(records, valid);
            for (std::size_t k = 0; k < valid.size(); ++k) {
                aboutOrigin.add(block[k]);
                colours.add(records, valid[k], scan);
                if (!gridded) continue;
                const double row = records(kRow, valid[k]), column = records(kColumn, valid[k]);
                constexpr double kMost = std::numeric_limits<std::int32_t>::max();
                gridded = std::abs(row) < kMost && std::abs(column) < kMost;
                if (gridded) scan.row.push_back(static_cast<std::int32_t>(row));
                if (gridded) scan.column.push_back(static_cast<std::int32_t>(column));
            }
            done += static_cast<std::int64_t>(n);
        }
        reader.close();
        if (done != count)
            throw Failure("scan '" + source.name + "' holds only " + std::to_string(done) + " of the " +
                              std::to_string(count) + " points it claims",
                          source.path, kPointsDamaged);
        const std::optional<glm::dvec3> origin = aboutOrigin.finish();
        scan.invalidPoints = count - static_cast<std::int64_t>(scan.pointsInScanner.size());
        colours.finish(scan);
        if (origin) scan.worldFromScanner.translation = scan.worldFromScanner * *origin;
        if (!gridded || origin)
            forgetGrid(scan);
        else
            settleGrid(scan);
        result.intensities = colours.takeIntensities();
    });
    return result;
}

} // namespace

Scan readE57Scan(const ScanSource& source) {
    return readAs(source, false).scan;
}

ScanWithIntensity readE57ScanWithIntensity(const ScanSource& source) {
    return readAs(source, true);
}

} // namespace scene
