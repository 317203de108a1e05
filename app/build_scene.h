#pragma once
// A build: import or capture -> align -> project -> refine -> scene file, each stage kept under a key.

#include "app/positions.h"

#include "scene/capture/cube_capture.h"
#include "scene/capture/light.h"
#include "scene/project/cube_faces.h"
#include "scene/project/dropouts.h"
#include "scene/pyramid.h"
#include "scene/refine/cover.h"
#include "scene/refine/fusion.h"
#include "scene/refine/redundancy.h"
#include "scene/refine/silhouettes.h"
#include "scene/refine/skins.h"

#include <filesystem>
#include <string>
#include <vector>

namespace app {

/// What the user may ask of a build; the parts' own options, once.
struct BuildOptions {
    std::vector<std::filesystem::path> inputs;
    std::filesystem::path output;
    std::string holdOut;                  ///< every:N:FIRST, a file of names, or empty
    std::size_t memoryBytes = 8ull << 30; ///< pixels held at a time
    /// Where scans and photographs stand: given, auto, or a file of matches between scans; empty: scans as given,
    /// photographs adjusted.
    std::string registration;
    std::filesystem::path scanner; ///< file of a calibrated scanner, or empty
    std::filesystem::path camera;  ///< of the photographs in E57 files, with its lens; empty: as the file says
    bool cull = true;              ///< false: every sample is kept
    bool fuse = true;              ///< false: kept samples stay as they were captured
    PositionsWish positions;       ///< of polygon scenes
    int mostPositions = 0;         ///< where they are searched for; 0: kMostSearched
    int faceSize = 512;            ///< of their images, pixels
    scene::CaptureLight light;
    scene::PolygonViewOptions polygonView;
    scene::CubeFaceOptions cubeFaces;
    scene::DropoutOptions dropouts;
    scene::GuessOptions guesses;
    scene::SkinOptions skins;
    scene::RedundancyOptions redundancy;
    scene::FusionOptions fusion;
    bool settleSilhouettes = true; ///< of photographs with range; false: samples stay at the range they came with
    scene::SilhouetteOptions silhouettes;
    bool evenColour = false; ///< true: exposure and white balance of overlapping images are made even
    bool findUnseen = false; ///< true: coverage is built, and what no image observed is shown as unseen
    scene::CoverOptions coverage;
    scene::PyramidOptions pyramid;

    /// Whether scans are to be registered, and photographs with range laid on each other.
    bool movesScans() const { return !registration.empty() && registration != "given"; }
    bool movesPhotographs() const { return registration != "given"; }
};

/// Builds the scene folder; nothing stands under its name before it is whole. Throws scene::Failure.
void buildScene(const BuildOptions& options);

} // namespace app
