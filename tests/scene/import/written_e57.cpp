#include "tests/scene/import/written_e57.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include <E57Format.h>
#include <gtest/gtest.h>

// libE57Format and its XML parser leak a little for every damaged file they refuse: the reader's packet
// cache, the text of the parser's message. Ours must not leak, so only theirs is excepted.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:CompressedVectorReaderImpl\nleak:libxerces-c\n";
}

namespace scene {
namespace {

constexpr std::size_t kPage = 1024, kPayload = 1020;

void setPose(e57::ImageFile& file, e57::StructureNode& node, const WrittenPose& pose) {
    e57::StructureNode poseNode(file), rotation(file), translation(file);
    rotation.set("w", e57::FloatNode(file, pose.w));
    rotation.set("x", e57::FloatNode(file, pose.x));
    rotation.set("y", e57::FloatNode(file, pose.y));
    rotation.set("z", e57::FloatNode(file, pose.z));
    translation.set("x", e57::FloatNode(file, pose.tx));
    translation.set("y", e57::FloatNode(file, pose.ty));
    translation.set("z", e57::FloatNode(file, pose.tz));
    poseNode.set("rotation", rotation);
    poseNode.set("translation", translation);
    node.set("pose", poseNode);
}

void setNumbers(e57::ImageFile& file, e57::StructureNode& node, const std::string& group,
                const std::vector<WrittenNumber>& numbers) {
    if (numbers.empty()) return;
    e57::StructureNode child(file);
    for (const auto& [name, value] : numbers)
        child.set(name, e57::FloatNode(file, value));
    node.set(group, child);
}

e57::Node prototypeOf(e57::ImageFile& file, const WrittenField& field) {
    switch (field.type) {
    case NumberType::float32:
        return e57::FloatNode(file, 0.0, e57::E57_SINGLE);
    case NumberType::float64:
        return e57::FloatNode(file, 0.0, e57::E57_DOUBLE);
    case NumberType::integer:
        return e57::IntegerNode(file, field.minimum, field.minimum, field.maximum);
    case NumberType::scaled:
        break;
    }
    return e57::ScaledIntegerNode(file, field.minimum, field.minimum, field.maximum, field.scale, field.offset);
}

std::uint32_t crc32c(const char* bytes, std::size_t size) {
    std::uint32_t crc = 0xffffffffu;
    for (std::size_t i = 0; i < size; ++i) {
        crc ^= static_cast<unsigned char>(bytes[i]);
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1) ^ (crc & 1 ? 0x82f63b78u : 0u);
    }
    return ~crc;
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    std::memcpy(&bytes[at], &value, sizeof value);
}

template <class T>
T get(const std::string& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, &bytes[at], sizeof value);
    return value;
}

} // namespace

TemporaryFolder::TemporaryFolder() {
    std::random_device random;
    path_ = std::filesystem::temp_directory_path() / ("revisit-scans-" + std::to_string(random()));
    std::filesystem::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

void writeE57(const std::filesystem::path& path, const std::vector<WrittenScan>& scans,
              const std::vector<WrittenImage>& images) {
    e57::ImageFile file(path.string(), "w");
    e57::StructureNode root = file.root();
    file.extensionsAdd("", e57::E57_V1_0_URI);
    root.set("formatName", e57::StringNode(file, "ASTM E57 3D Imaging Data File"));
    e57::VectorNode data3D(file, true), images2D(file, true);
    root.set("data3D", data3D);
    root.set("images2D", images2D);
    for (const WrittenScan& scan : scans) {
        e57::StructureNode node(file);
        data3D.append(node);
        if (!scan.name.empty()) node.set("name", e57::StringNode(file, scan.name));
        if (scan.pose) setPose(file, node, *scan.pose);
        setNumbers(file, node, "indexBounds", scan.indexBounds);
        setNumbers(file, node, "colorLimits", scan.colorLimits);
        setNumbers(file, node, "intensityLimits", scan.intensityLimits);
        e57::StructureNode prototype(file);
        std::vector<e57::SourceDestBuffer> buffers;
        std::vector<std::vector<double>> values;
        for (const WrittenField& field : scan.fields)
            values.push_back(field.values);
        for (std::size_t i = 0; i < scan.fields.size(); ++i) {
            prototype.set(scan.fields[i].name, prototypeOf(file, scan.fields[i]));
            if (!values[i].empty())
                buffers.emplace_back(file, scan.fields[i].name, values[i].data(), values[i].size(), true, true);
        }
        e57::CompressedVectorNode points(file, prototype, e57::VectorNode(file, true));
        node.set("points", points);
        if (values.empty() || values[0].empty()) continue;
        e57::CompressedVectorWriter writer = points.writer(buffers);
        writer.write(values[0].size());
        writer.close();
    }
    for (const WrittenImage& image : images) {
        e57::StructureNode node(file), representation(file);
        images2D.append(node);
        node.set("name", e57::StringNode(file, image.name));
        if (image.pose) setPose(file, node, *image.pose);
        node.set(image.representation, representation);
        for (const auto& [name, value] : image.numbers)
            representation.set(name, e57::FloatNode(file, value));
        e57::BlobNode blob(file, static_cast<std::int64_t>(image.jpeg.size()));
        representation.set("jpegImage", blob);
        std::vector<std::uint8_t> bytes = image.jpeg;
        blob.write(bytes.data(), 0, bytes.size());
    }
    file.close();
}

std::vector<WrittenField> cartesian(const std::vector<double>& x, const std::vector<double>& y,
                                    const std::vector<double>& z) {
    return {{"cartesianX", NumberType::float64, x},
            {"cartesianY", NumberType::float64, y},
            {"cartesianZ", NumberType::float64, z}};
}

std::string readBytes(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::string withoutChecksums(const std::string& fileBytes) {
    std::string content;
    for (std::size_t at = 0; at < fileBytes.size(); at += kPage)
        content += fileBytes.substr(at, kPayload);
    return content;
}

std::string withChecksums(const std::string& content) {
    std::string padded = content, file;
    padded.resize((content.size() + kPayload - 1) / kPayload * kPayload, ' ');
    for (std::size_t at = 0; at < padded.size(); at += kPayload) {
        file.append(padded, at, kPayload);
        const std::uint32_t crc = crc32c(&padded[at], kPayload);
        for (int shift = 24; shift >= 0; shift -= 8)
            file += static_cast<char>(crc >> shift);
    }
    return file;
}

std::string withXml(const std::string& fileBytes, const std::function<std::string(std::string)>& change) {
    std::string content = withoutChecksums(fileBytes);
    const auto physical = get<std::uint64_t>(content, 24), length = get<std::uint64_t>(content, 32);
    const std::size_t start = physical / kPage * kPayload + physical % kPage;
    const std::string xml = change(content.substr(start, length));
    content = content.substr(0, start) + xml;
    const std::size_t pages = (content.size() + kPayload - 1) / kPayload;
    put(content, 16, static_cast<std::uint64_t>(pages * kPage));
    put(content, 32, static_cast<std::uint64_t>(xml.size()));
    return withChecksums(content);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << "the file has no " << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

} // namespace scene
