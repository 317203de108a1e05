#include "scene/capture/write_scans.h"

#include "scene/errors.h"
#include "scene/synthetic_random.h"
#include "scene/unfinished_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdio>
#include <fstream>
#include <span>

#include <E57Format.h>

namespace scene {

namespace {

constexpr std::size_t kBlockPoints = 1 << 16;

void setPose(e57::ImageFile& file, e57::StructureNode& node, const Pose& fileFromScanner) {
    const glm::dvec4 q = quaternionOf(fileFromScanner);
    const glm::dvec3& t = fileFromScanner.translation;
    e57::StructureNode pose(file), rotation(file), translation(file);
    rotation.set("w", e57::FloatNode(file, q.w));
    rotation.set("x", e57::FloatNode(file, q.x));
    rotation.set("y", e57::FloatNode(file, q.y));
    rotation.set("z", e57::FloatNode(file, q.z));
    translation.set("x", e57::FloatNode(file, t.x));
    translation.set("y", e57::FloatNode(file, t.y));
    translation.set("z", e57::FloatNode(file, t.z));
    pose.set("rotation", rotation);
    pose.set("translation", translation);
    node.set("pose", pose);
}

/// Names what is written, the same for the same content: two hashes in the form that others expect.
std::string guidOf(const std::string& name, std::uint64_t content) {
    std::uint64_t high = mixBits(content, name.size()), low = mixBits(~content, name.size());
    for (const char letter : name)
        high = mixBits(high, static_cast<unsigned char>(letter)), low = mixBits(low ^ high, content);
    char text[48];
    std::snprintf(text, sizeof text, "{%08llX-%04llX-%04llX-%04llX-%012llX}",
                  static_cast<unsigned long long>(high >> 32), static_cast<unsigned long long>(high >> 16 & 0xffff),
                  static_cast<unsigned long long>(high & 0xffff), static_cast<unsigned long long>(low >> 48),
                  static_cast<unsigned long long>(low & 0xffffffffffff));
    return text;
}

std::string guidOf(const ScanWithIntensity& written) {
    std::uint64_t content = written.scan.pointsInScanner.size();
    for (const glm::vec3& p : written.scan.pointsInScanner)
        content = mixBits(content ^ std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y));
    return guidOf(written.scan.name, content);
}

/// One block of points, field by field, in the memory that libE57Format reads from.
struct Block {
    std::array<std::vector<float>, 4> numbers;      ///< x y z, intensity
    std::array<std::vector<std::int32_t>, 5> whole; ///< row, column, red, green, blue

    Block() {
        for (auto& field : numbers)
            field.resize(kBlockPoints);
        for (auto& field : whole)
            field.resize(kBlockPoints);
    }

    void fill(const ScanWithIntensity& from, std::size_t first, std::size_t count) {
        const Scan& scan = from.scan;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3& p = scan.pointsInScanner[first + i];
            const Rgb8& colour = scan.colours[first + i];
            numbers[0][i] = p.x, numbers[1][i] = p.y, numbers[2][i] = p.z;
            numbers[3][i] = from.intensities[first + i];
            if (scan.rows > 0) whole[0][i] = scan.row[first + i], whole[1][i] = scan.column[first + i];
            whole[2][i] = colour.r, whole[3][i] = colour.g, whole[4][i] = colour.b;
        }
    }
};

void setNumbers(e57::ImageFile& file, e57::StructureNode& node, const char* group,
                std::initializer_list<std::pair<const char*, e57::Node>> numbers) {
    e57::StructureNode child(file);
    for (const auto& [name, number] : numbers)
        child.set(name, number);
    node.set(group, child);
}

/// Returns the name by which photographs say that they belong to it.
std::string addScan(e57::ImageFile& file, e57::VectorNode& data3D, const ScanWithIntensity& written, Block& block) {
    const Scan& scan = written.scan;
    assert(written.intensities.size() == scan.pointsInScanner.size());
    e57::StructureNode node(file);
    data3D.append(node);
    node.set("name", e57::StringNode(file, scan.name));
    const std::string guid = guidOf(written);
    node.set("guid", e57::StringNode(file, guid));
    setPose(file, node, scan.worldFromScanner);
    const auto [low, high] = std::minmax_element(written.intensities.begin(), written.intensities.end());
    const bool isEmpty = written.intensities.empty(), isGrid = scan.rows > 0;
    setNumbers(file, node, "intensityLimits",
               {{"intensityMinimum", e57::FloatNode(file, isEmpty ? 0.0 : double{*low})},
                {"intensityMaximum", e57::FloatNode(file, isEmpty ? 1.0 : double{*high})}});

    e57::StructureNode prototype(file);
    std::vector<e57::SourceDestBuffer> buffers;
    const auto addNumber = [&](const char* name, std::vector<float>& values) {
        prototype.set(name, e57::FloatNode(file, 0.0, e57::E57_SINGLE));
        buffers.emplace_back(file, name, values.data(), values.size(), true, false);
    };
    const auto addWhole = [&](const char* name, std::vector<std::int32_t>& values, int highest) {
        prototype.set(name, e57::IntegerNode(file, 0, 0, highest));
        buffers.emplace_back(file, name, values.data(), values.size(), true, false);
    };
    addNumber("cartesianX", block.numbers[0]);
    addNumber("cartesianY", block.numbers[1]);
    addNumber("cartesianZ", block.numbers[2]);
    addNumber("intensity", block.numbers[3]);
    if (isGrid) {
        addWhole("rowIndex", block.whole[0], scan.rows - 1);
        addWhole("columnIndex", block.whole[1], scan.columns - 1);
        setNumbers(file, node, "indexBounds",
                   {{"rowMinimum", e57::IntegerNode(file, 0)},
                    {"rowMaximum", e57::IntegerNode(file, scan.rows - 1)},
                    {"columnMinimum", e57::IntegerNode(file, 0)},
                    {"columnMaximum", e57::IntegerNode(file, scan.columns - 1)}});
    }
    if (scan.hasColour) {
        addWhole("colorRed", block.whole[2], 255);
        addWhole("colorGreen", block.whole[3], 255);
        addWhole("colorBlue", block.whole[4], 255);
        setNumbers(file, node, "colorLimits",
                   {{"colorRedMinimum", e57::IntegerNode(file, 0)},
                    {"colorRedMaximum", e57::IntegerNode(file, 255)},
                    {"colorGreenMinimum", e57::IntegerNode(file, 0)},
                    {"colorGreenMaximum", e57::IntegerNode(file, 255)},
                    {"colorBlueMinimum", e57::IntegerNode(file, 0)},
                    {"colorBlueMaximum", e57::IntegerNode(file, 255)}});
    }
    e57::CompressedVectorNode points(file, prototype, e57::VectorNode(file, true));
    node.set("points", points);
    const std::size_t count = scan.pointsInScanner.size();
    if (count == 0) return guid;
    e57::CompressedVectorWriter writer = points.writer(buffers);
    for (std::size_t first = 0; first < count; first += kBlockPoints) {
        const std::size_t size = std::min(kBlockPoints, count - first);
        block.fill(written, first, size);
        writer.write(size);
    }
    writer.close();
    return guid;
}

/// E57 has a camera look along -Z with Y up. Lengths are in metres there; of the sensor only ratios are known here, so
/// it is taken to have pixels of 5 micrometres.
void addPhotograph(e57::ImageFile& file, e57::VectorNode& images2D, const WrittenPhotograph& written,
                   const std::string& guidOfScan) {
    constexpr double kPixelMetres = 5e-6;
    const Camera& camera = written.camera;
    e57::StructureNode node(file), pinhole(file);
    images2D.append(node);
    node.set("name", e57::StringNode(file, written.name));
    std::uint64_t content = written.jpeg.size();
    for (const std::uint8_t byte : written.jpeg)
        content = mixBits(content, byte);
    node.set("guid", e57::StringNode(file, guidOf(written.name, content)));
    node.set("associatedData3DGuid", e57::StringNode(file, guidOfScan));
    setPose(file, node, written.worldFromCamera * headFromCamera());
    node.set("pinholeRepresentation", pinhole);
    pinhole.set("imageWidth", e57::IntegerNode(file, camera.width));
    pinhole.set("imageHeight", e57::IntegerNode(file, camera.height));
    pinhole.set("focalLength", e57::FloatNode(file, camera.fx * kPixelMetres));
    pinhole.set("pixelWidth", e57::FloatNode(file, kPixelMetres));
    pinhole.set("pixelHeight", e57::FloatNode(file, kPixelMetres * camera.fx / camera.fy));
    pinhole.set("principalPointX", e57::FloatNode(file, camera.cx));
    pinhole.set("principalPointY", e57::FloatNode(file, camera.cy));
    e57::BlobNode blob(file, static_cast<std::int64_t>(written.jpeg.size()));
    pinhole.set("jpegImage", blob);
    std::vector<std::uint8_t> bytes = written.jpeg;
    if (!bytes.empty()) blob.write(bytes.data(), 0, bytes.size());
}

} // namespace

void writeE57(const std::filesystem::path& path, std::size_t count,
              const std::function<ScanWithIntensity(std::size_t)>& scanAt, const WrittenPhotographs& photographs) {
    try {
        const UnfinishedFile unfinished(path);
        // The library would make the file for its owner alone; of one that is there it keeps who may read it.
        std::ofstream(unfinished.path()).close();
        e57::ImageFile file(unfinished.path().string(), "w");
        e57::StructureNode root = file.root();
        file.extensionsAdd("", e57::E57_V1_0_URI);
        root.set("formatName", e57::StringNode(file, "ASTM E57 3D Imaging Data File"));
        root.set("guid", e57::StringNode(file, guidOf(path.stem().string(), count)));
        root.set("versionMajor", e57::IntegerNode(file, 1));
        root.set("versionMinor", e57::IntegerNode(file, 0));
        e57::VectorNode data3D(file, true), images2D(file, true);
        root.set("data3D", data3D);
        root.set("images2D", images2D);
        Block block;
        try {
            std::vector<std::string> guids;
            for (std::size_t i = 0; i < count; ++i)
                guids.push_back(addScan(file, data3D, scanAt(i), block));
            for (std::size_t i = 0; i < photographs.count; ++i) {
                const WrittenPhotograph photograph = photographs.at(i);
                addPhotograph(file, images2D, photograph, guids.at(photograph.scan));
            }
            file.close();
            unfinished.finish();
        } catch (...) {
            file.cancel(); // which removes the file
            throw;
        }
    } catch (const e57::E57Exception& exception) {
        throw Failure("cannot be written as E57 (" + e57::Utilities::errorCodeToString(exception.errorCode()) + ")",
                      path, kWriteRemedy);
    }
}

} // namespace scene
