// refine: overlaps, skins, what is kept, fusion and tiles, in files.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/refine/open_spaces.h"
#include "scene/scene_file.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

namespace app {

namespace {

using nlohmann::json;

constexpr int kRefineVersion = 13, kTilesVersion = 6, kCoverageVersion = 3;

json describe(const scene::ComparisonOptions& o) {
    return {o.sameSurface, o.pixelError};
}

/// Half of the memory for pixels; the rest is for what the stages keep beside them. Each image is asked for again by
/// those that overlap it.
scene::ImageStore openImages(const std::vector<scene::StoredImage>& images, const BuildOptions& options,
                             const StageStore& store) {
    return {images, options.memoryBytes / 2, store.folder()};
}

/// Half for pixels and for what the one at hand becomes, and the trees: of large images and little memory that is more,
/// since pixels keep an eighth of the whole.
scene::ImageStore openImagesToCover(const std::vector<scene::StoredImage>& images, const BuildOptions& options) {
    const std::uint64_t half = options.memoryBytes / 2, buffers = scene::OpenSpaces::bytesOfBuffers(images);
    const std::uint64_t trees = scene::bytesToCover(options.coverage);
    return {images, std::max(half - std::min(half, buffers + trees), half / 4)};
}

bool isThere(const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
}

scene::Image<scene::Keep> readKept(const std::filesystem::path& file, const scene::Camera& camera) {
    const scene::Image<std::uint8_t> bytes = scene::readFlagsTiff(file, camera);
    scene::Image<scene::Keep> kept(camera.width, camera.height);
    for (std::size_t i = 0; i < kept.size(); ++i)
        kept.pixels()[i] = static_cast<scene::Keep>(bytes.pixels()[i]);
    return kept;
}

/// Of one image, as the stage keeps them.
json describe(const scene::SkinFigures& f) {
    json words = json::array();
    for (const scene::PartnerWord& word : f.words)
        words.push_back({word.image, word.agrees, word.sawThrough, word.apartMetres});
    return {f.samples, f.triangles, f.planarSkins, f.seenThrough, f.floating,
            f.guesses, f.confirmed, f.refuted,     words,         f.floatingInside};
}

scene::SkinFigures skinFiguresOf(const json& f, std::size_t images, const std::filesystem::path& file) {
    scene::SkinFigures figures{f.at(0), f.at(1), f.at(2), f.at(3), f.at(4), f.at(9), f.at(5), f.at(6), f.at(7), {}};
    for (const json& word : f.at(8)) {
        figures.words.push_back({word.at(0), word.at(1), word.at(2), word.at(3)});
        if (figures.words.back().image >= images)
            throw scene::Failure("is damaged", file, "remove the folder it is in and build again");
    }
    return figures;
}

} // namespace

Overlaps findOverlaps(const ImportedImages& imported, const BuildOptions& options) {
    scene::ImageStore images(imported.images, options.memoryBytes / 2);
    std::vector<scene::ImageOutline> outlines(images.size());
    Progress progress("overlaps", images.size());
    scene::visitEach(images, 1, [&](std::size_t i) {
        outlines[i] = scene::outlineOf(*images.borrow(i));
        progress.advance();
    });
    Overlaps overlaps;
    overlaps.partners = scene::findPartners(outlines);
    for (const auto& partners : overlaps.partners)
        overlaps.pairs += std::ssize(partners);
    overlaps.pairs /= 2;
    std::vector<float> shown;
    for (const scene::ImageOutline& outline : outlines)
        std::copy_if(outline.disparity.begin(), outline.disparity.end(), std::back_inserter(shown),
                     [](float disparity) { return disparity > 0; });
    if (shown.empty()) return overlaps;
    constexpr double kNearlyAll = 0.99;
    std::sort(shown.begin(), shown.end(), std::greater<>());
    const auto metresAt = [&](double share) {
        return 1.0 /
               static_cast<double>(shown[static_cast<std::size_t>(share * static_cast<double>(shown.size() - 1))]);
    };
    overlaps.medianMetres = metresAt(0.5), overlaps.nearlyAllMetres = metresAt(kNearlyAll);
    return overlaps;
}

SkinStage markSkins(const ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options,
                    StageStore& store) {
    const scene::SkinOptions& o = options.skins;
    SkinStage stage;
    stage.key = keyOf({kRefineVersion, imported.key, o.planarity, o.maxPartners, describe(o.comparison)});
    const std::filesystem::path folder = store.folderOf("skins", stage.key);
    scene::ImageStore images = openImages(imported.images, options, store);
    stage.images = imported.images;
    std::vector<scene::SkinFigures> figures(images.size());
    Progress progress("skins", images.size());
    scene::visitEach(images, 4, [&](std::size_t i) { // the image, a partner, what is marked and what is asked
        const std::string name = imported.images[i].name;
        const std::filesystem::path flagsFile = folder / (name + ".flags.tiff"),
                                    figuresFile = folder / (name + ".json");
        if (!isThere(figuresFile)) {
            writeFlagsTiff(scene::markSkins(images, i, overlaps.partners[i], o, figures[i]), flagsFile);
            writeWhole(figuresFile, describe(figures[i]).dump());
        } else {
            figures[i] = skinFiguresOf(readJson(figuresFile), images.size(), figuresFile);
        }
        stage.images[i].flagsFile = flagsFile;
        progress.advance();
    });
    for (const scene::SkinFigures& f : figures) {
        stage.figures.samples += f.samples, stage.figures.triangles += f.triangles;
        stage.figures.planarSkins += f.planarSkins, stage.figures.seenThrough += f.seenThrough;
        stage.figures.floating += f.floating, stage.figures.floatingInside += f.floatingInside;
        stage.figures.guesses += f.guesses;
        stage.figures.confirmed += f.confirmed, stage.figures.refuted += f.refuted;
    }
    stage.contradictions = scene::findContradictions(figures);
    stage.ofImages = std::move(figures);
    return stage;
}

KeepStage keepBest(const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins,
                   const BuildOptions& options, StageStore& store) {
    const scene::RedundancyOptions& o = options.redundancy;
    KeepStage stage;
    stage.key = keyOf({kRefineVersion, skins.key, options.cull, o.preference, o.baselineShare, o.minPatchShare,
                       o.tileSize, describe(o.comparison)});
    Progress progress("redundancy", imported.images.size());
    std::size_t told = 0;
    const std::filesystem::path folder = store.find("kept", stage.key, [&](const std::filesystem::path& part) {
        scene::ImageStore images = openImages(skins.images, options, store);
        scene::RedundancyFigures figures;
        std::vector<scene::KeepMap> kept;
        if (options.cull) {
            kept = scene::findKept(images, overlaps.partners, o, figures, [&] { progress.advance(), ++told; });
        } else {
            for (const scene::StoredImage& image : skins.images)
                kept.emplace_back(image.camera.width, image.camera.height, scene::Keep::base);
            const scene::SkinFigures& f = skins.figures;
            const std::int64_t surfaces = f.samples + f.confirmed - f.floating;
            figures = {surfaces, surfaces, 0, f.guesses};
        }
        for (std::size_t i = 0; i < kept.size(); ++i) {
            const scene::Image<scene::Keep> keeps = kept[i].whole();
            scene::Image<std::uint8_t> bytes(keeps.width(), keeps.height());
            for (std::size_t k = 0; k < bytes.size(); ++k)
                bytes.pixels()[k] = static_cast<std::uint8_t>(keeps.pixels()[k]);
            writeFlagsTiff(bytes, part / (imported.images[i].name + ".tiff"));
        }
        writeWhole(part / "figures.json",
                   json{figures.samples, figures.base, figures.directional, figures.guesses}.dump());
    });
    if (told < imported.images.size()) progress.advance(imported.images.size() - told);
    const json figures = readJson(folder / "figures.json");
    stage.figures = {figures.at(0), figures.at(1), figures.at(2), figures.at(3)};
    for (const scene::StoredImage& image : imported.images)
        stage.files.push_back(folder / (image.name + ".tiff"));
    return stage;
}

TileStage fuseAndCut(const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins,
                     const KeepStage& kept, const BuildOptions& options, StageStore& store) {
    scene::FusionOptions o = options.fusion;
    if (!options.fuse) o.maxPartners = 0;
    const std::string key = keyOf({kRefineVersion, kTilesVersion, kept.key, o.maxPartners, o.angleRadians, o.colourStep,
                                   describe(o.comparison), options.pyramid.tileSize, options.pyramid.facetTolerance,
                                   options.pyramid.sameSurface});
    const std::filesystem::path folder = store.folderOf("tiles", key);
    scene::ImageStore images = openImages(skins.images, options, store);
    TileStage stage;
    for (const scene::StoredImage& image : imported.images) {
        stage.blocks.push_back(folder / (image.name + ".block"));
        stage.flags.push_back(folder / (image.name + ".flags.tiff"));
    }
    Progress progress("fusion", images.size());
    scene::visitEach(images, 8, [&](std::size_t i) { // the image, a partner, the means, and tiles of all levels
        // The block is written last: where it is, the flags are too.
        if (!isThere(stage.blocks[i])) {
            const scene::DepthImage fused =
                scene::fuse(images, i, overlaps.partners[i], readKept(kept.files[i], imported.images[i].camera), o);
            writeFlagsTiff(fused.flags, stage.flags[i]);
            writeWhole(stage.blocks[i], scene::packTiles(scene::cutIntoLevels(fused, options.pyramid)));
        }
        progress.advance();
    });
    return stage;
}

CoverageStage coverSpace(const SkinStage& skins, const BuildOptions& options, StageStore& store) {
    CoverageStage stage;
    if (!options.findUnseen) return stage;
    const scene::CoverOptions& o = options.coverage;
    const std::string key = keyOf({kCoverageVersion, skins.key, o.cellsPerSample, o.surfaceSamples, o.nearestMetres,
                                   o.tolerance, o.bodyMetres, o.maxNodes});
    Progress progress("coverage", 3 * skins.images.size());
    const std::filesystem::path folder = store.find("coverage", key, [&](const std::filesystem::path& part) {
        scene::ImageStore images = openImagesToCover(skins.images, options);
        scene::CoverFigures f;
        writeCoverage(scene::cover(images, o, f, [&] { progress.advance(); }), part / scene::kCoverageFile);
        writeWhole(part / "figures.json", json{f.nodes, f.cellsPerSample, f.finestMetres, f.unseenCubicMetres,
                                               f.surfaceCubicMetres, f.emptyCubicMetres}
                                              .dump());
    });
    const json f = readJson(folder / "figures.json");
    stage.figures = {f.at(0), f.at(1), f.at(2), f.at(3), f.at(4), f.at(5)};
    stage.file = folder / scene::kCoverageFile;
    return stage;
}

} // namespace app
