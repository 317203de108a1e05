#include "scene/import/importer.h"

#include "scene/cube.h"
#include "scene/errors.h"
#include "scene/import/e57.h"
#include "scene/import/polygons.h"
#include "scene/import/ptx.h"
#include "scene/import/scan_name.h"
#include "scene/import/scan_photos.h"
#include "scene/import/transforms_json.h"
#include "scene/import/tum_rgbd.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

namespace scene {

namespace {

std::string lowerCaseExtension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

void append(std::vector<ScanSource>& scans, std::vector<ScanSource> more) {
    scans.insert(scans.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void openE57Input(const std::filesystem::path& input, Capture& capture) {
    std::vector<ScanSource> scans = listE57(input, capture.remarks);
    if (scans.empty()) return;
    std::vector<ScanPhoto> photos = listScanPhotos(input, scans, capture.scans.size(), capture.remarks);
    std::stable_sort(photos.begin(), photos.end(), [](const auto& a, const auto& b) { return a.scan < b.scan; });
    append(capture.scans, std::move(scans));
    capture.scanPhotos.insert(capture.scanPhotos.end(), photos.begin(), photos.end());
}

void openInput(const std::filesystem::path& input, Capture& capture) {
    std::error_code ignored;
    if (!std::filesystem::exists(input, ignored)) throw Failure("no such file or folder", input, "check the path");
    if (std::filesystem::is_directory(input)) {
        if (std::filesystem::exists(input / "transforms.json"))
            return listTransformsJson(input / "transforms.json", capture);
        if (std::filesystem::exists(input / "rgb.txt") && std::filesystem::exists(input / "groundtruth.txt"))
            return listTumRgbd(input, capture);
        if (std::filesystem::exists(input / "scene.json") && std::filesystem::exists(input / "tiles.bin"))
            throw Failure("is a scene already, not a capture", input,
                          "walk, render or measure it; to build it anew, name the capture that it was made of");
        for (std::filesystem::directory_iterator at(input, ignored), end; !ignored && at != end;
             at.increment(ignored)) {
            const std::string extension = lowerCaseExtension(at->path());
            if (extension == ".e57" || extension == ".ptx")
                throw Failure("is a folder of scans", input,
                              "name the files themselves, e.g. " + (input / ("*" + extension)).string());
        }
        throw Failure("folder holds no capture that Revisit knows", input,
                      "it needs a transforms.json with depth, or rgb.txt, depth.txt and groundtruth.txt (TUM)");
    }
    const std::string extension = lowerCaseExtension(input);
    if (extension == ".json") return listTransformsJson(input, capture);
    if (extension == ".e57") return openE57Input(input, capture);
    if (extension == ".ptx") return append(capture.scans, listPtx(input, capture.remarks));
    if (isPolygonFile(input)) return capture.polygons.push_back(input);
    throw Failure(
        "format " + (extension.empty() ? std::string("without an extension") : extension) + " is not known", input,
        "give an .e57, a .ptx, a transforms.json, a folder in TUM layout, or polygons as .gltf, .glb or .obj");
}

/// One picture of two places is wrong at one of them at least.
void remarkDoubled(Capture& capture) {
    std::map<std::filesystem::path, const PhotoSource*> first;
    for (const PhotoSource& photo : capture.photos) {
        std::error_code error;
        const std::filesystem::path path = std::filesystem::weakly_canonical(photo.colourPath, error);
        const auto [at, isNew] = first.try_emplace(error ? photo.colourPath : path, &photo);
        if (isNew) continue;
        const Pose &a = at->second->worldFromCamera, &b = photo.worldFromCamera;
        const bool isSame = a.rotation == b.rotation && a.translation == b.translation;
        capture.remarks.push_back("Photograph '" + photo.colourPath.string() + "' is listed twice" +
                                  (isSame ? "." : ", as taken from two places: one of them is wrong."));
    }
}

/// Bytes of the UTF-8 character at the start of text; 0 if none starts there.
std::size_t bytesOfCharacter(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::size_t count = byte(0) < 0x80   ? 1
                              : byte(0) < 0xc2 ? 0
                              : byte(0) < 0xe0 ? 2
                              : byte(0) < 0xf0 ? 3
                              : byte(0) < 0xf5 ? 4
                                               : 0;
    if (count > text.size()) return 0;
    for (std::size_t i = 1; i < count; ++i)
        if ((byte(i) & 0xc0) != 0x80) return 0;
    // Longer than need be, surrogates, and what is beyond Unicode.
    if ((byte(0) == 0xe0 && byte(1) < 0xa0) || (byte(0) == 0xed && byte(1) > 0x9f) ||
        (byte(0) == 0xf0 && byte(1) < 0x90) || (byte(0) == 0xf4 && byte(1) > 0x8f))
        return 0;
    return count;
}

/// Names become file names in UTF-8: letters, digits, dash, underscore and dot of any alphabet stay, the rest becomes a
/// dash.
std::string fileNameOf(const std::string& name) {
    constexpr std::size_t kMaxNameBytes = 100;
    std::string clean;
    for (std::string_view rest = name; !rest.empty();) {
        const std::size_t bytes = bytesOfCharacter(rest);
        if (clean.size() + std::max<std::size_t>(bytes, 1) > kMaxNameBytes) break;
        const auto c = static_cast<unsigned char>(rest.front());
        const bool stays = bytes > 1 || (bytes == 1 && (std::isalnum(c) || c == '-' || c == '_' || c == '.'));
        clean += stays ? rest.substr(0, bytes) : "-";
        rest.remove_prefix(std::max<std::size_t>(bytes, 1));
    }
    if (clean.empty() || clean.front() == '.') clean.insert(0, "item");
    return clean;
}

template <class Source>
void makeNamesUnique(std::vector<Source>& sources, std::unordered_set<std::string>& taken) {
    for (Source& source : sources) {
        const std::string wanted = fileNameOf(source.name);
        source.name = wanted;
        for (int i = 2; !taken.insert(source.name).second; ++i)
            source.name = wanted + "-" + std::to_string(i);
    }
}

int toCount(std::string_view text, const std::string& rule) {
    int value = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < 0)
        throw Failure("is not every:N:FIRST", "--hold-out " + rule, "write e.g. every:20:10, or name a file of names");
    return value;
}

/// Such numbers are mistakes, and take time and memory without end.
void requirePlausible(const Camera& camera, const std::string& name, const std::filesystem::path& path) {
    // Over the larger side, for pictures may be cut to strips: focal lengths of 179 and of half a degree, the widest
    // and the narrowest that there are, and a centre no farther out than that of a small piece of a picture.
    constexpr double kShortest = 0.008, kLongest = 115, kFarthestCentre = 20;
    const int side = std::max(camera.width, camera.height);
    const auto isPlausible = [&](double focal, double centre) {
        return focal >= kShortest * side && focal <= kLongest * side && std::abs(centre) <= kFarthestCentre * side;
    };
    if (!isPlausible(camera.fx, camera.cx) || !isPlausible(camera.fy, camera.cy))
        throw Failure("the camera of '" + name +
                          "' is none that takes pictures: its focal length or centre is out of "
                          "proportion to " +
                          std::to_string(camera.width) + "x" + std::to_string(camera.height) + " pixels",
                      path, "correct its intrinsics, which are in pixels");
}

void requirePlausible(const Pose& worldFromIt, const std::string& name, const std::filesystem::path& path) {
    constexpr double kFarthestMetres = 1e8; // coordinates about the earth's centre are a tenth of it
    const glm::dvec3& t = worldFromIt.translation;
    if (!(std::abs(t.x) <= kFarthestMetres && std::abs(t.y) <= kFarthestMetres && std::abs(t.z) <= kFarthestMetres))
        throw Failure("'" + name + "' stands more than 100,000 km from the origin", path, "correct its pose");
}

/// All photographs, those beside scans last, by whatever a person may call them.
class PhotographNames {
  public:
    explicit PhotographNames(const Capture& capture) {
        for (const PhotoSource& photo : capture.photos)
            names_.emplace(photo.name, names_.size());
        for (const ScanPhoto& photo : capture.scanPhotos)
            names_.emplace(photo.name, names_.size());
        // What their files are called differs where it cannot be an image's name, or is two photographs'.
        for (std::size_t i = 0; i < capture.photos.size(); ++i)
            for (const std::filesystem::path& name :
                 {capture.photos[i].colourPath.stem(), capture.photos[i].colourPath.filename()})
                files_.emplace(name.string(), i);
    }

    std::optional<std::size_t> find(const std::string& name) const {
        if (const auto found = names_.find(name); found != names_.end()) return found->second;
        if (const auto found = files_.find(name); found != files_.end()) return found->second;
        // As names became those of images: of photographs, and of what stands in a scan's file.
        std::set<std::string> taken;
        for (const std::string& clean : {fileNameOf(name), scanName(name, {}, taken)}) {
            if (clean.size() != name.size()) continue; // others may begin like a name that is cut
            if (const auto found = names_.find(clean); found != names_.end()) return found->second;
        }
        return std::nullopt;
    }

  private:
    std::unordered_map<std::string, std::size_t> names_, files_;
};

/// Which of all photographs, those beside scans last, a file names; ascending.
std::vector<std::size_t> readNames(const Capture& capture, const std::string& path) {
    const PhotographNames names(capture);
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw Failure("no such file", "--hold-out " + path,
                      "write every:N:FIRST, or name a file with an image name on each line");
    std::vector<std::size_t> named;
    std::string name;
    for (std::size_t line = 1; std::getline(file, name); ++line) {
        while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back())))
            name.pop_back();
        if (name.empty()) continue;
        const std::optional<std::size_t> found = names.find(name);
        if (!found)
            throw Failure("no image is called '" + name + "'", atLine(path, line),
                          "names are the pictures' file names, with or without extension");
        named.push_back(*found);
    }
    std::sort(named.begin(), named.end());
    named.erase(std::unique(named.begin(), named.end()), named.end());
    return named;
}

} // namespace

Capture openCapture(std::span<const std::filesystem::path> inputs) {
    Capture capture;
    for (const std::filesystem::path& input : inputs)
        openInput(input, capture);
    if (!capture.polygons.empty() && inputs.size() > 1)
        throw Failure("polygons are built alone", capture.polygons.front(), "give this file and no other input");
    remarkDoubled(capture);
    std::unordered_set<std::string> taken;
    makeNamesUnique(capture.scans, taken);
    for (const ScanSource& scan : capture.scans)
        for (const char* const face : kFaceNames) { // the images that scans become, which nothing else is called
            const std::string image = scan.name + "-" + face;
            taken.insert(image);
            for (int layer = 2; layer <= kMostFurtherLayers + 1; ++layer)
                taken.insert(image + "-" + std::to_string(layer));
        }
    makeNamesUnique(capture.photos, taken);
    makeNamesUnique(capture.scanPhotos, taken);
    for (const PhotoSource& photo : capture.photos) {
        requirePlausible(photo.camera, photo.name, photo.colourPath);
        requirePlausible(photo.worldFromCamera, photo.name, photo.colourPath);
    }
    for (const ScanSource& scan : capture.scans)
        requirePlausible(scan.worldFromScanner, scan.name, scan.path);
    return capture;
}

HeldOut findHeldOut(const Capture& capture, const std::string& rule) {
    std::vector<std::size_t> chosen; // of all photographs, those beside scans last
    const std::size_t photos = capture.photos.size(), all = photos + capture.scanPhotos.size();
    if (rule.starts_with("every:")) {
        const std::string_view numbers = std::string_view(rule).substr(6);
        const std::size_t colon = numbers.find(':');
        const int step = toCount(numbers.substr(0, colon), rule);
        const int first = colon == std::string_view::npos ? 0 : toCount(numbers.substr(colon + 1), rule);
        if (step < 1) throw Failure("N is 0", "--hold-out " + rule, "write e.g. every:20:10");
        for (auto i = static_cast<std::size_t>(first); i < all; i += static_cast<std::size_t>(step))
            chosen.push_back(i);
    } else if (!rule.empty()) {
        chosen = readNames(capture, rule);
    }
    HeldOut heldOut;
    for (const std::size_t i : chosen)
        (i < photos ? heldOut.photos : heldOut.scanPhotos).push_back(i < photos ? i : i - photos);
    return heldOut;
}

} // namespace scene
