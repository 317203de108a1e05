// revisit: walk back into a place that was captured with depth. The command line; DESIGN.md's is stable.

#include "app/build_scene.h"
#include "app/calibrate.h"
#include "app/info.h"
#include "app/measure_scene.h"
#include "app/plan_scene.h"
#include "app/real_range.h"
#include "app/render_scene.h"
#include "app/sizes.h"
#include "app/version.h"
#include "app/walk_scene.h"

#include "scene/errors.h"

#include <CLI/CLI.hpp>

#include <tbb/global_control.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <new>
#include <numbers>
#include <optional>

namespace {

constexpr int kDone = 0, kCouldNot = 1, kWrongUsage = 2;

/// What is asked of polygon scenes alone.
void addCapture(CLI::App& build, app::BuildOptions& options) {
    const std::string group = "Polygons";
    build
        .add_option_function<std::string>(
            "--positions", [&](const std::string& text) { options.positions = app::parsePositions(text); },
            "where reference images are taken: how many, spread over free space; auto: such that walkers see most of "
            "what there is; or a JSON file of places in the file's own coordinates: {\"positions\": [[x, y, z], ...]}")
        ->type_name("N|auto|FILE")
        ->group(group);
    build
        .add_option("--count", options.mostPositions,
                    "with --positions auto: how many at most; default " + std::to_string(app::kMostSearched))
        ->check(CLI::Range(1, 100'000))
        ->group(group);
    build.add_option("--face-size", options.faceSize, "pixels along the side of each of the six images of a position")
        ->check(CLI::Range(scene::kLeastFaceSize, scene::kMostFaceSize))
        ->capture_default_str()
        ->group(group);
    scene::CaptureLight& light = options.light;
    build
        .add_option_function<std::vector<double>>(
            "--towards-sun", [&](const std::vector<double>& v) { light.towardsSun = app::parseDirection(v); },
            "direction of the sun, three numbers; +Y is up")
        ->expected(3)
        ->type_name("X Y Z")
        ->group(group);
    const auto addStrength = [&](const std::string& name, double& strength, const std::string& what) {
        build.add_option(name, strength, what)->check(app::realRange(0.0, 100.0))->capture_default_str()->group(group);
    };
    addStrength("--sun", light.sunStrength, "times the sun's usual strength; 0: none");
    addStrength("--sky", light.skyStrength, "times the sky's");
    addStrength("--fill", light.fillStrength, "times that of the light which comes from everywhere, less in corners");
    build.add_option("--light-rays", light.rays, "rays for the light at a place")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str()
        ->group(group);
}

void addBuild(CLI::App& program, app::BuildOptions& options, std::string& memory, int& threads) {
    CLI::App* build = program.add_subcommand("build", "Turn a capture into a scene.");
    build
        ->add_option(
            "INPUT", options.inputs,
            "transforms.json (or its folder), a TUM RGB-D folder, .e57, .ptx; or polygons: .gltf, .glb, .obj, ...")
        ->required();
    build->add_option("-o,--output", options.output, "folder of the scene")->required();
    build->add_option("--hold-out", options.holdOut,
                      "keep photographs out to compare with, those in E57 files, too: every:N:FIRST, or a file of "
                      "names");
    build->add_flag_callback(
        "--no-fuse", [&] { options.fuse = false; }, "keep samples as captured instead of fusing those that agree");
    build->add_flag_callback(
        "--no-silhouettes", [&] { options.settleSilhouettes = false; },
        "photographs: leave samples beside silhouettes at the range they came with, instead of on the side where other "
        "photographs show the same colours");
    build->add_flag_callback(
        "--no-cull", [&] { options.cull = false; }, "keep every sample, redundant or not");
    build
        ->add_option("--cull-preference", options.redundancy.preference,
                     "how much better sampled a tile must be to be preferred to one of a more central image")
        ->check(app::realRange(1.0, 1e6))
        ->capture_default_str();
    build
        ->add_option("--cull-baseline", options.redundancy.baselineShare,
                     "threshold of redundancy: a surface is kept again where no kept image stands nearer than this "
                     "share of its range; "
                     "0 keeps each surface once")
        ->check(app::realRange(0.0, 10.0))
        ->capture_default_str();
    build
        ->add_option("--cull-patch", options.redundancy.minPatchShare,
                     "a tile is kept again, whole, where at least this share of it is wanted")
        ->check(app::realRange(0.0, 1.0))
        ->capture_default_str();
    build
        ->add_option("--same-surface", options.skins.comparison.sameSurface,
                     "relative difference in depth up to which two images mean the same surface")
        ->check(app::realRange(1e-5, 0.5))
        ->capture_default_str();
    build
        ->add_option("--guess-radius", options.guesses.radius,
                     "photographs: range that was not measured is guessed from this many pixels about, and shown as "
                     "filled unless another image confirms it; 0: never")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    build
        ->add_option("--dropout-radius", options.dropouts.radius,
                     "photographs: gaps of range within a surface, up to so many pixels wide, are closed by the range "
                     "about them; more than a pixel from what was measured that is shown as filled; 0: never")
        ->check(CLI::Range(0, 20))
        ->capture_default_str();
    build->add_flag_callback(
        "--coverage", [&] { options.findUnseen = true; },
        "find out which space no image observed, and show it as unseen: for scans; slow to draw without a graphics "
        "card");
    build->add_flag(
        "--open-sky", options.cubeFaces.opensSky,
        "with --coverage, of scans that were taken under the open sky: rays that came back with nothing from "
        "above the horizon, as far as they hang together with the uppermost, met the sky, and what lies "
        "along them was seen to be empty; glass that reaches up to the sky counts, too");
    build
        ->add_option("--mesh-tolerance", options.pyramid.facetTolerance,
                     "share of depth by which the adaptive mesh may leave the samples")
        ->check(app::realRange(0.0, 0.1))
        ->capture_default_str();
    build->add_option("--tile-size", options.pyramid.tileSize, "samples along the side of a tile")
        ->check(CLI::Range(1, scene::kMaxTileSize))
        ->capture_default_str();
    addCapture(*build, options);
    build->add_option("--memory", memory, "pixels held at a time, e.g. 8G")->capture_default_str();
    build->add_option("--threads", threads, "0: all")->check(CLI::Range(0, 1024))->capture_default_str();
    build
        ->add_option("--register", options.registration,
                     "where scans and photographs stand: given, as their files say; auto, found by what they have in "
                     "common; or a JSON file of places on planes that two scans share, the other pairs being found "
                     "as by auto. Without it scans stay as given, and photographs with range (of captures without "
                     "scans) are laid on each other from where they are said to stand")
        ->type_name("given|auto|FILE");
    build->add_option("--scanner", options.scanner,
                      "scans of a panning scanner are read anew with the constants in this file, which 'revisit "
                      "calibrate scanner' makes");
    build->add_flag("--colour-even", options.evenColour,
                    "make exposure and white balance of overlapping images even; held-out pictures stay as taken");
    build
        ->add_option("--camera", options.camera,
                     "JSON file of the camera and lens (k1, k2, ...) of the photographs in E57 files, which cannot say "
                     "how a lens distorts")
        ->type_name("FILE");
    build->footer("Examples:\n"
                  "  revisit build living_room/ -o room.revisit\n"
                  "  revisit build scan_a.e57 scan_b.e57 -o site.revisit --memory 4G\n"
                  "  revisit build room.gltf -o room.revisit --positions 8\n"
                  "  revisit build capture/ -o test.revisit --hold-out every:20:10   # then: revisit render "
                  "test.revisit --out frames\n"
                  "\nWhat the stages leave behind stands in SCENE.build: a build that was stopped goes on there. It "
                  "may be removed.");
}

std::string optionOf(const app::Knob& knob) {
    std::string option = "--" + knob.name;
    std::replace(option.begin(), option.end(), '_', '-');
    return option;
}

/// How a scene is drawn: the same wherever one is.
void addDrawOptions(CLI::App& command, app::DrawOptions& options) {
    const std::string group = "Speed and accuracy";
    command.add_option("--quality", options.quality, "fast, balanced, best, or a JSON file of knobs")
        ->capture_default_str()
        ->group(group);
    for (const app::Knob& knob : app::knobs())
        command
            .add_option_function<std::string>(
                optionOf(knob),
                [&options, &knob](const std::string& text) {
                    nlohmann::json value = nlohmann::json::parse(text, nullptr, false);
                    if (value.is_discarded()) value = text; // a name
                    render::Quality probe;
                    if (!knob.set(probe, value))
                        throw CLI::ValidationError(optionOf(knob) + ": " + text + " is not " + knob.values);
                    options.turned.emplace_back(knob.name, std::move(value));
                },
                knob.does + ": " + knob.values)
            ->type_name("")
            ->group(group);
    command.add_option("--polygons", options.polygons,
                       "polygons (.gltf, .obj, ...) that stand in the scene, in its world coordinates, such as a model "
                       "of what is missing; shown as filled, since nobody measured them");
    command.add_flag("--hide-unseen", options.hideUnseen,
                     "show space that no image ever observed as emptiness instead of dark stripes");
    command
        .add_option("--coverage-cell", options.coverageCellMetres,
                    "tell unseen space by cells of this many metres at least, e.g. 0.02: less exact, faster, less "
                    "memory; 0: as built")
        ->check(app::realRange(0.0, 100.0))
        ->capture_default_str()
        ->group(group);
    command.add_option("--ipd", options.eyeDistanceMetres, "metres between the eyes")
        ->check(app::realRange(0.0, 1.0))
        ->capture_default_str();
}

void addThreads(CLI::App& command, int& threads) {
    command.add_option("--threads", threads, "0: all")->check(CLI::Range(0, 1024))->capture_default_str();
}

void addRender(CLI::App& program, app::RenderOptions& options, std::string& size, std::string& memory, int& threads) {
    CLI::App* render = program.add_subcommand(
        "render", "Draw a scene into picture files, in stereo along a path or from given cameras.");
    render->add_option("SCENE", options.scene, "folder that 'revisit build' made")->required();
    render->add_option("--out", options.out, "folder for pictures and report.json")->required();
    auto* path = render->add_option("--path", options.path, "path file: where the head goes");
    render->add_option("--cameras", options.cameras, "cameras file; without it and --path: the held-out cameras")
        ->excludes(path);
    render->add_option("--size", size, "WxH; default 640x480 for paths, the cameras' own otherwise");
    render->add_option("--eyes", options.eyes, "2 or 1; default 2 for paths, 1 for cameras")
        ->check(CLI::IsMember({1, 2}));
    render->add_flag("--aux", options.aux, "write depth and class, too");
    addDrawOptions(*render, options.draw);
    render->add_option("--memory", memory, "what of the scene may be loaded at a time, e.g. 8G")->capture_default_str();
    addThreads(*render, threads);
    render
        ->add_option_function<std::string>(
            "--overlay", [&](const std::string&) { options.showsCells = true; },
            "cells: reference positions and the walk cells between them, drawn over the pictures")
        ->check(CLI::IsMember({"cells"}));
    render->footer("Examples:\n"
                   "  revisit render room.revisit --out frames --path walk.json\n"
                   "  revisit render room.revisit --out frames --cameras cameras.json --eyes 1 --aux --warp mesh");
}

void addWalk(CLI::App& program, app::WalkOptions& options, std::string& size, std::string& memory, int& threads) {
    CLI::App* walk = program.add_subcommand(
        "walk", "Walk through a scene in a headset (any OpenXR runtime), or without a display along a path.");
    walk->add_option("SCENE", options.scene, "folder that 'revisit build' made")->required();
    auto* desktop = walk->add_flag("--desktop", options.isAtDesk, "a window on the desk, even if there is a headset");
    auto* path = walk->add_option("--path", options.path, "path file: where the walker is led, by time");
    walk->add_flag("--headless", options.isHeadless, "no headset and no window: along --path, frame by frame")
        ->excludes(desktop)
        ->needs(path);
    walk->add_option("--record", options.record, "path file to write: where the head went");
    auto* const out =
        walk->add_option("--out", options.out, "folder for report.json, and for pictures with --picture-every");
    walk->add_option("--picture-every", options.pictureEvery,
                     "keep what both eyes were given, and cameras.json to draw it again, every so many frames")
        ->check(CLI::Range(1, 1 << 30))
        ->needs(out);
    walk->add_option("--frames", options.frames, "end after so many")->check(CLI::Range(1, 1 << 30));
    walk->add_option("--rate", options.framesPerSecond,
                     "frames a second: along the path without a display (default 90); of a headset, the nearest it "
                     "offers")
        ->check(app::realRange(1.0, 1000.0));
    walk->add_flag_callback(
        "--hold-rate", [&] { options.holdsRate = true; },
        "give up quality while --rate is not held; so it is anyway, except with --headless");
    walk->add_flag_callback(
        "--fixed-quality", [&] { options.holdsRate = false; }, "draw as asked, however long it takes");
    walk->add_option("--size", size, "WxH of an eye without a display; default 640x480");
    addDrawOptions(*walk, options.draw);
    walk->add_option("--memory", memory, "what of the scene may be loaded at a time, e.g. 8G")->capture_default_str();
    addThreads(*walk, threads);
    walk->footer(
        "Examples:\n"
        "  revisit walk room.revisit                      # in the headset, or at the desk until there is one\n"
        "  revisit walk room.revisit --desktop            # at the desk\n"
        "  revisit walk room.revisit --record walk.json   # and remember where the head went\n"
        "  revisit walk room.revisit --headless --path walk.json --out report");
}

void addMeasure(CLI::App& program, app::MeasureOptions& options, std::string& size, std::string& memory, int& threads) {
    CLI::App* measure = program.add_subcommand(
        "measure", "Try settings of drawing: how long frames take, how far pictures are from held-out photographs.");
    measure->add_option("SCENE", options.scene, "folder that 'revisit build --hold-out' made")->required();
    measure->add_option("--out", options.out, "folder for report.json, table.md and the worst pictures")->required();
    measure->add_option("--cameras", options.cameras,
                        "cameras file with what each took beside it: NAME.png, .jpg or .tiff, and NAME-depth.tiff if "
                        "known; without it: the held-out photographs");
    measure->add_option("--path", options.path, "path file that is timed; without it: from camera to camera");
    measure->add_option("--size", size, "WxH of an eye along the path; default 640x480");
    measure->add_option("--frames", options.frames, "so many along the path")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    auto* settings = measure->add_option("--settings", options.settings,
                                         "file of settings to measure: {\"settings\": [{\"name\": \"a\", knobs}]}");
    measure
        ->add_option("--sweep", options.sweep,
                     "knobs to turn one at a time, by their names in files; without it: all of them")
        ->delimiter(',')
        ->excludes(settings);
    addDrawOptions(*measure, options.draw);
    measure->add_option("--memory", memory, "what of the scene may be loaded at a time, e.g. 8G")
        ->capture_default_str();
    addThreads(*measure, threads);
    measure->footer(
        "Every setting is drawn at every place in turn, so that what else the machine does meets all alike.\n"
        "Examples:\n"
        "  revisit measure room.revisit --out figures\n"
        "  revisit measure room.revisit --out figures --quality best --sweep resolution_scale");
}

void addPlan(CLI::App& program, app::PlanOptions& options, int& threads) {
    CLI::App* plan = program.add_subcommand(
        "plan", "Say where the next scans should stand to show most of what nobody has seen yet.");
    plan->add_option("SCENE", options.scene, "folder that 'revisit build --coverage' made")->required();
    plan->add_option("--out", options.out, "JSON file to write; a picture from above stands beside it (.png)")
        ->required();
    plan->add_option("--count", options.next.count, "how many scans; fewer where more would show hardly anything")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    plan->add_option("--tripod", options.next.tripodMetres, "metres of the scanner above the floor")
        ->check(app::realRange(0.3, 10.0))
        ->capture_default_str();
    addThreads(*plan, threads);
    plan->footer("What a scan would reveal is an estimate: nobody knows what stands in space that was never seen.\n"
                 "Examples:\n"
                 "  revisit build scans/*.e57 -o site.revisit --coverage && revisit plan site.revisit --out plan.json\n"
                 "  revisit plan site.revisit --out plan.json --count 5 --tripod 1.8");
}

void addCalibrate(CLI::App& program, app::CalibrateOptions& options) {
    CLI::App* calibrate = program.add_subcommand(
        "calibrate", "Find what is particular to a camera or a scanner, for builds to take account of.");
    calibrate->require_subcommand(1);
    const auto add = [&](const std::string& name, const std::string& does, const std::string& inputs) {
        CLI::App* command = calibrate->add_subcommand(name, does);
        command->add_option("INPUT", options.inputs, inputs)->required();
        command->add_option("-o,--output", options.output, "JSON file to write")->required();
        return command;
    };
    CLI::App* camera = add("camera", "From pictures of a checkerboard, seen tilted and from near and far.",
                           "pictures, or folders of them");
    camera
        ->add_option_function<std::string>(
            "--board",
            [&options](const std::string& text) {
                std::tie(options.board.columns, options.board.rows) = app::parseSize(text, "--board", "9x6");
                if (options.board.columns < 3 || options.board.rows < 3)
                    throw CLI::ValidationError("--board " + text, "has fewer than 3 inner corners to a side");
            },
            "inner corners of the board, across and down")
        ->type_name("COLUMNSxROWS")
        ->default_str("9x6");
    camera
        ->add_option_function<double>(
            "--square-mm", [&options](double millimetres) { options.board.squareMetres = millimetres / 1000; },
            "width of a square of the board")
        ->check(app::realRange(0.01, 1e5))
        ->default_str("25");
    camera
        ->add_option("--corner-window", options.board.windowPixels,
                     "pixels to each side of a corner that it is found from; 0: a quarter of the way to the next")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    calibrate->footer("Example:\n  revisit calibrate camera boards/*.jpg --board 9x6 --square-mm 25 -o camera.json");
    camera->footer("Example:\n  revisit calibrate camera boards/*.jpg --board 9x6 --square-mm 25 -o camera.json");

    CLI::App* scanner = add("scanner",
                            "From scans of a panning scanner among walls; best if the pan unit went all round, so "
                            "that each half of the mirror's turn took everything.",
                            ".e57 or .ptx scans on a grid of half turns of the mirror");
    scene::ScannerConstants<double>& believed = options.believed;
    scanner->add_option("--pan-steps", believed.panStepsPerHalfTurn, "of half a turn, as the scans were computed with")
        ->check(app::realRange(100.0, 1e8))
        ->capture_default_str();
    scanner
        ->add_option_function<double>(
            "--mirror-deg", [&believed](double degrees) { believed.mirrorRadians = degrees * std::numbers::pi / 180; },
            "angle of the mirror they were computed with")
        ->check(app::realRange(30.0, 60.0))
        ->default_str("45");
    scanner->add_option("--horizon", believed.horizonPosition, "position of the encoder where the beam leaves level")
        ->check(app::realRange(-4096.0, 4096.0))
        ->capture_default_str();
    scanner
        ->add_option_function<double>(
            "--mirror-mm", [&believed](double millimetres) { believed.mirrorMetres = millimetres / 1000; },
            "from the rangefinder's zero to the mirror")
        ->check(app::realRange(-1e4, 1e4))
        ->default_str("120");
    scanner->footer("Example:\n  revisit calibrate scanner walls.e57 -o scanner.json\n"
                    "  revisit build site.e57 --scanner scanner.json -o site.revisit");
}

bool isCommand(const CLI::App& program, const std::string& name) {
    const std::vector<const CLI::App*> commands = program.get_subcommands([](const CLI::App*) { return true; });
    return std::ranges::any_of(commands, [&](const CLI::App* command) { return command->check_name(name); });
}

/// The name of what a command that is asked for must be told, and was told as nothing; empty if there is none such.
std::string emptyRequired(const CLI::App& command) {
    for (const CLI::Option* option : command.get_options())
        if (option->get_required() && std::ranges::find(option->results(), "") != option->results().end())
            return option->get_name();
    for (const CLI::App* called : command.get_subcommands())
        if (const std::string name = emptyRequired(*called); !name.empty()) return name;
    return {};
}

int sayWrongUsage(const std::string& what) {
    std::fprintf(stderr, "revisit: %s; run with --help for more information\n", what.c_str());
    return kWrongUsage;
}

int run(int argc, char** argv) {
    CLI::App program{"Revisit: walk back into a place that was photographed or scanned with depth."};
    program.set_version_flag("--version", std::string("revisit ") + app::kVersion + " (" + app::kCommit + ")");
    program.require_subcommand(1);
    program.footer("Example:\n  revisit build capture/ -o room.revisit && revisit render room.revisit --out frames "
                   "--path walk.json\n"
                   "\nEach command has its own --help.");

    app::BuildOptions buildOptions;
    app::RenderOptions renderOptions;
    app::WalkOptions walkOptions;
    app::MeasureOptions measureOptions;
    app::PlanOptions planOptions;
    app::CalibrateOptions calibrateOptions;
    std::string memory = "8G", size;
    std::filesystem::path infoScene;
    bool infoAsJson = false;
    int threads = 0;
    addBuild(program, buildOptions, memory, threads);
    addRender(program, renderOptions, size, memory, threads);
    addWalk(program, walkOptions, size, memory, threads);
    addMeasure(program, measureOptions, size, memory, threads);
    addPlan(program, planOptions, threads);
    addCalibrate(program, calibrateOptions);
    CLI::App* info = program.add_subcommand("info", "Say what a scene is and what was built into it.");
    info->add_option("SCENE", infoScene, "folder that 'revisit build' made")->required();
    info->add_flag("--json", infoAsJson, "as JSON, for programs");
    info->footer("Example:\n  revisit info room.revisit --json");

    if (argc > 1 && argv[1][0] != '-' && !isCommand(program, argv[1]))
        return sayWrongUsage("'" + scene::onOneLine(argv[1]) + "' is no command");
    try {
        program.parse(argc, argv);
        buildOptions.memoryBytes = app::parseBytes(memory);
        renderOptions.draw.memoryBytes = walkOptions.draw.memoryBytes = measureOptions.draw.memoryBytes =
            buildOptions.memoryBytes;
        if (!size.empty()) {
            std::tie(renderOptions.width, renderOptions.height) = app::parseSize(size);
            std::tie(walkOptions.width, walkOptions.height) = app::parseSize(size);
            std::tie(measureOptions.width, measureOptions.height) = app::parseSize(size);
        }
    } catch (const CLI::ParseError& e) {
        return program.exit(e) == 0 ? kDone : kWrongUsage;
    }
    if (const std::string name = emptyRequired(program); !name.empty()) return sayWrongUsage(name + " is empty");
    buildOptions.redundancy.comparison = buildOptions.fusion.comparison = buildOptions.skins.comparison;
    buildOptions.redundancy.tileSize = buildOptions.pyramid.tileSize;

    std::optional<tbb::global_control> limit;
    if (threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    if (program.got_subcommand("build")) app::buildScene(buildOptions);
    if (program.got_subcommand("render")) app::renderScene(renderOptions);
    if (program.got_subcommand("walk")) app::walkScene(walkOptions);
    if (program.got_subcommand("measure")) app::measureScene(measureOptions);
    if (program.got_subcommand("plan")) app::planScene(planOptions);
    if (const CLI::App* const calibrate = program.get_subcommand("calibrate"); calibrate->parsed()) {
        if (calibrate->got_subcommand("camera")) app::calibrateCamera(calibrateOptions);
        if (calibrate->got_subcommand("scanner")) app::calibrateScanner(calibrateOptions);
    }
    if (program.got_subcommand("info")) app::printInfo(infoScene, infoAsJson);
    return kDone;
}

} // namespace

int main(int argc, char** argv) {
    // A file may not grow beyond what the user is allowed: told where it is written, as a full disk is.
    std::signal(SIGXFSZ, SIG_IGN);
    try {
        const int outcome = run(argc, argv);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return outcome;
        std::fprintf(stderr,
                     "revisit: standard output: cannot be written to; check the disk or the program it goes to\n");
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "revisit: memory: not enough for this; lower --memory, or close other programs\n");
    } catch (const std::exception& e) {
        std::fprintf(stderr, "revisit: %s\n", scene::onOneLine(e.what()).c_str());
    }
    return kCouldNot;
}
