#include "scene/import/e57_file.h"

#include "scene/errors.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <string_view>
#include <vector>

#include <xercesc/sax/SAXException.hpp>
#include <xercesc/util/OutOfMemoryException.hpp>
#include <xercesc/util/XMLException.hpp>

namespace scene {
namespace {

// The file header and the pages that every E57 file is cut into (ASTM E2807, section 5): 1020 bytes and their
// checksum.
constexpr std::uint64_t kPageBytes = 1024, kPagePayload = 1020, kHeaderBytes = 48;
constexpr int kMaxDepth = 100; ///< of XML elements; a scan's deepest number stands at 8

const char* const kDamaged = "copy or export the scan again";

struct FileHead {
    std::uint64_t fileBytes = 0, xmlOffset = 0, xmlBytes = 0, pageBytes = 0;
};

template <class T>
T littleEndian(const char* bytes) {
    static_assert(std::endian::native == std::endian::little, "E57 is little-endian, and so is all we run on");
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

FileHead readHeader(std::ifstream& stream, const std::filesystem::path& path, std::uint64_t fileBytes) {
    std::array<char, kHeaderBytes> bytes{};
    if (fileBytes < kHeaderBytes || !stream.read(bytes.data(), bytes.size()))
        throw Failure("is too short to be an E57 file", path, "check that the file was copied whole");
    if (std::string_view(bytes.data(), 8) != "ASTM-E57")
        throw Failure("is not an E57 file: it does not begin with ASTM-E57", path, "name a scan in E57 or PTX");
    const FileHead header{littleEndian<std::uint64_t>(&bytes[16]), littleEndian<std::uint64_t>(&bytes[24]),
                          littleEndian<std::uint64_t>(&bytes[32]), littleEndian<std::uint64_t>(&bytes[40])};
    if (header.fileBytes != fileBytes)
        throw Failure("is cut off or damaged: its header promises " + std::to_string(header.fileBytes) +
                          " bytes and there are " + std::to_string(fileBytes),
                      path, kDamaged);
    if (header.pageBytes != kPageBytes || fileBytes % kPageBytes != 0)
        throw Failure("has pages of a size that E57 does not know", atByte(path, 40), kDamaged);
    if (header.xmlOffset < kHeaderBytes || header.xmlOffset >= fileBytes || header.xmlBytes > fileBytes ||
        header.xmlOffset + header.xmlBytes > fileBytes)
        throw Failure("has an XML section that lies outside the file", atByte(path, 24), kDamaged);
    return header;
}

std::string readXml(std::ifstream& stream, const FileHead& header, const std::filesystem::path& path) {
    std::string xml;
    xml.reserve(header.xmlBytes);
    std::array<char, kPageBytes> page{};
    for (std::uint64_t at = header.xmlOffset; xml.size() < header.xmlBytes; at = (at / kPageBytes + 1) * kPageBytes) {
        const std::uint64_t inPage = at % kPageBytes;
        if (at + kPageBytes - inPage > header.fileBytes || inPage >= kPagePayload)
            throw Failure("has an XML section that lies outside the file", atByte(path, 24), kDamaged);
        stream.seekg(static_cast<std::streamoff>(at - inPage));
        if (!stream.read(page.data(), page.size()))
            throw Failure("cannot be read", atByte(path, at), "check the disk it stands on");
        xml.append(&page[inPage], std::min(kPagePayload - inPage, header.xmlBytes - xml.size()));
    }
    return xml;
}

// Where the tag, comment or CDATA block that begins at `at` ends: at its '>'. npos: nowhere.
std::size_t endOfMarkup(std::string_view xml, std::size_t at) {
    const auto endAfter = [&](std::string_view end) {
        const std::size_t found = xml.find(end, at);
        return found == std::string_view::npos ? found : found + end.size() - 1;
    };
    const std::string_view rest = xml.substr(at);
    if (rest.starts_with("<![CDATA[")) return endAfter("]]>");
    if (rest.starts_with("<!--")) return endAfter("-->");
    for (std::size_t i = at + 1; i < xml.size(); ++i) { // a '>' within quotes does not end a tag
        if (xml[i] == '>') return i;
        if (xml[i] == '"' || xml[i] == '\'') i = std::min(xml.find(xml[i], i + 1), xml.size());
    }
    return std::string_view::npos;
}

// libE57Format lets its parser follow document types, entities and schema locations: a scan could then open
// files and network addresses, or grow without bound. It also recurses once for each level of nesting. No
// scan needs any of it.
void checkXml(std::string_view xml, const std::filesystem::path& path) {
    const auto refuse = [&](const std::string& what) { throw Failure(what, path, kDamaged); };
    for (const std::string_view word : {"<!DOCTYPE", "<!ENTITY", "schemaLocation", "SchemaLocation"})
        if (xml.find(word) != std::string_view::npos)
            refuse("has an XML section with '" + std::string(word) + "', which no scan needs");
    // In another encoding the words above could hide from us and still be read by the parser.
    const std::string_view head = xml.substr(0, xml.find('>'));
    if (xml.find('\0') != std::string_view::npos || xml.find("<?xml") > 3 ||
        (head.find("encoding") != std::string_view::npos && head.find("UTF-8") == std::string_view::npos &&
         head.find("utf-8") == std::string_view::npos))
        refuse("has an XML section that is not in UTF-8");
    int depth = 0;
    for (std::size_t at = xml.find('<'); at != std::string_view::npos; at = xml.find('<', at + 1)) {
        const std::size_t close = endOfMarkup(xml, at);
        if (close == std::string_view::npos) refuse("has an XML section that is cut off");
        const char next = xml[at + 1];
        if (next == '/')
            --depth;
        else if (next != '!' && next != '?' && xml[close - 1] != '/' && ++depth > kMaxDepth)
            refuse("has an XML section nested more than " + std::to_string(kMaxDepth) + " deep");
        at = close;
    }
    if (depth != 0) refuse("has an XML section that is cut off");
}

std::string plainWords(const e57::E57Exception& error) {
    switch (error.errorCode()) {
    case e57::E57_ERROR_BAD_CHECKSUM:
        return "is damaged: a checksum does not match";
    case e57::E57_ERROR_BAD_CV_HEADER:
    case e57::E57_ERROR_BAD_CV_PACKET:
        return "is damaged: the block that holds its points is not well formed";
    case e57::E57_ERROR_XML_PARSER:
    case e57::E57_ERROR_BAD_XML_FORMAT:
    case e57::E57_ERROR_BAD_PROTOTYPE:
    case e57::E57_ERROR_VALUE_OUT_OF_BOUNDS:
    case e57::E57_ERROR_BAD_NODE_DOWNCAST:
    case e57::E57_ERROR_PATH_UNDEFINED:
        return "is damaged: its XML section does not describe a scan as the standard wants it";
    case e57::E57_ERROR_UNKNOWN_FILE_VERSION:
        return "has an E57 version that is not known";
    case e57::E57_ERROR_OPEN_FAILED:
        return "cannot be opened";
    case e57::E57_ERROR_READ_FAILED:
    case e57::E57_ERROR_LSEEK_FAILED:
        return "cannot be read";
    default:
        return "is damaged";
    }
}

} // namespace

void withE57Failures(const std::filesystem::path& path, const std::function<void()>& work) {
    try {
        work();
    } catch (const Failure&) {
        throw;
    } catch (const e57::E57Exception& error) {
        throw Failure(plainWords(error) + " (" + e57::Utilities::errorCodeToString(error.errorCode()) + ")", path,
                      kDamaged);
    } catch (const std::bad_alloc&) {
        throw Failure("needs more memory than there is", path, "export fewer scans into one file");
    } catch (const std::exception& error) {
        throw Failure(std::string("cannot be read: ") + error.what(), path, kDamaged);
    } catch (const xercesc::OutOfMemoryException&) {
        throw Failure("needs more memory than there is", path, "export fewer scans into one file");
    } catch (const xercesc::XMLException&) {
        throw Failure("is damaged: its XML section is not well formed", path, kDamaged);
    } catch (const xercesc::SAXException&) {
        throw Failure("is damaged: its XML section is not well formed", path, kDamaged);
    }
}

e57::ImageFile openE57(const std::filesystem::path& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw Failure("is not there", path, "check the path");
    if (!std::filesystem::is_regular_file(status)) throw Failure("is not a file", path, "name a file");
    const std::uint64_t fileBytes = std::filesystem::file_size(path, error);
    std::ifstream stream(path, std::ios::binary);
    if (error || !stream) throw Failure("cannot be opened", path, "check its permissions");
    checkXml(readXml(stream, readHeader(stream, path, fileBytes), path), path);

    // The XML parser is started and stopped with each file, which is not safe on two threads at once.
    static std::mutex parserLock;
    const std::lock_guard lock(parserLock);
    return e57::ImageFile(path.string(), "r");
}

std::optional<e57::Node> childOf(const e57::StructureNode& parent, const std::string& name) {
    if (!parent.isDefined(name)) return std::nullopt;
    return parent.get(name);
}

std::optional<double> numberOf(const e57::StructureNode& parent, const std::string& name) {
    const auto node = childOf(parent, name);
    if (!node) return std::nullopt;
    switch (node->type()) {
    case e57::E57_INTEGER:
        return static_cast<double>(e57::IntegerNode(*node).value());
    case e57::E57_SCALED_INTEGER:
        return e57::ScaledIntegerNode(*node).scaledValue();
    case e57::E57_FLOAT:
        return e57::FloatNode(*node).value();
    default:
        return std::nullopt;
    }
}

std::string textOf(const e57::StructureNode& parent, const std::string& name) {
    const auto node = childOf(parent, name);
    return node && node->type() == e57::E57_STRING ? e57::StringNode(*node).value() : std::string();
}

Pose poseOf(const e57::StructureNode& parent, const std::string& what, const std::filesystem::path& path) {
    const auto node = childOf(parent, "pose");
    if (!node) return {};
    const e57::StructureNode pose(*node);
    glm::dvec4 q{0, 0, 0, 1};
    if (const auto rotation = childOf(pose, "rotation")) {
        const e57::StructureNode r(*rotation);
        q = {numberOf(r, "x").value_or(0), numberOf(r, "y").value_or(0), numberOf(r, "z").value_or(0),
             numberOf(r, "w").value_or(0)};
    }
    glm::dvec3 t{0.0};
    if (const auto translation = childOf(pose, "translation")) {
        const e57::StructureNode s(*translation);
        t = {numberOf(s, "x").value_or(0), numberOf(s, "y").value_or(0), numberOf(s, "z").value_or(0)};
    }
    double largest = 0;
    for (int i = 0; i < 4; ++i)
        largest = std::isfinite(q[i]) ? std::max(largest, std::abs(q[i])) : INFINITY;
    const bool finite = std::isfinite(t.x) && std::isfinite(t.y) && std::isfinite(t.z);
    if (!finite || !std::isfinite(largest) || largest == 0)
        throw Failure("the pose of " + what + " is not a place and a turn: numbers are missing or not finite", path,
                      "export it with its registration, or without a pose");
    q /= largest; // or the squares of very small or large numbers were lost
    return poseFromQuaternion(t, q.x, q.y, q.z, q.w);
}

std::int64_t childCountOf(const e57::ImageFile& file, const std::string& vectorName) {
    const auto node = childOf(file.root(), vectorName);
    return node ? e57::VectorNode(*node).childCount() : 0;
}

e57::StructureNode structureAt(const e57::ImageFile& file, const std::string& vectorName, std::int64_t index,
                               const std::filesystem::path& path) {
    if (index < 0 || index >= childCountOf(file, vectorName))
        throw Failure("has no item " + std::to_string(index) + " in " + vectorName, path,
                      "list its contents again: the file has changed");
    return e57::StructureNode(e57::VectorNode(file.root().get(vectorName)).get(index));
}

} // namespace scene
