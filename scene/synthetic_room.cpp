// The room of scene/synthetic.h. x to the right of one who enters and looks at the window in the wall y =
// depth.

#include "scene/synthetic.h"

#include "scene/synthetic_furniture.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kWidth = 5.2, kDepth = 4.2, kHeight = 2.7; // metres

class Room {
  public:
    explicit Room(std::uint32_t seed) : random_(seed) {
        model_.name = "room";
        model_.lightSpacing = 0.085;
        model_.exposure = 4.6;
        model_.sky.towardsSun = glm::normalize(glm::dvec3(-0.42, 0.72, 0.62));
        model_.sky.sun = glm::dvec3(2.8, 2.55, 2.15);
        model_.sky.zenith = glm::dvec3(0.55, 0.95, 1.75);
        model_.sky.horizon = glm::dvec3(1.7, 1.85, 2.0);
        model_.sky.seed = seed;
        white_ = addMaterial(model_, {Pattern::plaster, reflectance(0xf1ede4)});
        oak_ = addMaterial(model_, {Pattern::grain, reflectance(0x8a5a33), reflectance(0xc4935c), 1.0, 11});
        dark_ = addMaterial(model_, {Pattern::grain, reflectance(0x3d2719), reflectance(0x6b452b), 1.0, 12});
    }

    SyntheticModel build() {
        addShell();
        addWindow();
        addLamp();
        addFurniture();
        addWalls();
        addPaths();
        return std::move(model_);
    }

  private:
    void addShell() {
        const int floor =
            addMaterial(model_, {Pattern::planks, reflectance(0x8c6239), reflectance(0xc99f6b), 0.12, 21});
        const int wall = addMaterial(model_, {Pattern::plaster, reflectance(0xdfd8c8)});
        const int accent = addMaterial(model_, {Pattern::plaster, reflectance(0x7d9aa0)});
        addRectangle(model_, {0, 0, 0}, {kWidth, 0, 0}, {0, kDepth, 0}, floor);
        addRectangle(model_, {0, 0, kHeight}, {0, kDepth, 0}, {kWidth, 0, 0}, white_);
        addRectangle(model_, {kWidth, 0, 0}, {-kWidth, 0, 0}, {0, 0, kHeight}, accent);
        addRectangle(model_, {0, 0, 0}, {0, kDepth, 0}, {0, 0, kHeight}, wall);
        addRectangle(model_, {kWidth, kDepth, 0}, {0, -kDepth, 0}, {0, 0, kHeight}, wall);
        addRectangle(model_, {0, kDepth, 0}, {kWidth, 0, 0}, {0, 0, kHeight}, wall,
                     {{{left_, sill_}, {right_, lintel_}}});
        const Pose world;
        const double t = 0.014, h = 0.09;
        addBox(model_, world, {0, 0, 0}, {kWidth, t, h}, white_);
        addBox(model_, world, {0, kDepth - t, 0}, {kWidth, kDepth, h}, white_);
        addBox(model_, world, {0, t, 0}, {t, 0.30, h}, white_);
        addBox(model_, world, {0, 1.26, 0}, {t, kDepth - t, h}, white_);
        addBox(model_, world, {kWidth - t, t, 0}, {kWidth, kDepth - t, h}, white_);
    }

    void addWindow() {
        const double out = kDepth + 0.24;
        const Pose world;
        addRectangle(model_, {left_, kDepth, sill_}, {right_ - left_, 0, 0}, {0, 0.24, 0}, white_);
        addRectangle(model_, {left_, kDepth, lintel_}, {0, 0.24, 0}, {right_ - left_, 0, 0}, white_);
        addRectangle(model_, {left_, kDepth, sill_}, {0, 0.24, 0}, {0, 0, lintel_ - sill_}, white_);
        addRectangle(model_, {right_, out, sill_}, {0, -0.24, 0}, {0, 0, lintel_ - sill_}, white_);
        const double y0 = kDepth + 0.13, y1 = kDepth + 0.18, w = 0.055, middle = (left_ + right_) / 2;
        for (const double x : {left_, middle - w / 2, right_ - w})
            addBox(model_, world, {x, y0, sill_}, {x + w, y1, lintel_}, white_);
        for (const double z : {sill_, sill_ + 0.92, lintel_ - w})
            addBox(model_, world, {left_, y0 + 0.002, z}, {right_, y1 - 0.002, z + w}, white_);
        addBox(model_, world, {left_ - 0.08, kDepth - 0.16, sill_ - 0.035}, {right_ + 0.08, kDepth + 0.12, sill_},
               white_);
        model_.lamps.push_back({{left_, kDepth, sill_}, {right_ - left_, 0, 0}, {0, 0, lintel_ - sill_}, {}, true});

        const int curtain =
            addMaterial(model_, {Pattern::weave, reflectance(0xb9573f), reflectance(0xd98a6a), 1.0, 31});
        for (const double x : {left_ - 0.42, right_ - 0.10}) {
            const auto place = [&](double s, double t) {
                const double wave = std::sin(s * 44.0) * (0.030 + 0.02 * (1.0 - t)) + 0.012 * std::sin(s * 17.0 + x);
                return glm::dvec3(x + s * 0.52, kDepth - 0.10 + wave, 0.12 + t * 2.26);
            };
            addSheet(
                model_, 90, 12, place, [](double s, double t) { return glm::dvec3(s * 1.1, t * 2.26, 0); }, curtain);
        }
        addRod(model_, {left_ - 0.55, kDepth - 0.10, 2.42}, {right_ + 0.55, kDepth - 0.10, 2.42}, 0.015, dark_);
        const int metal = addMaterial(model_, {Pattern::plain, reflectance(0xe6e4de)});
        for (int rib = 0; rib < 16; ++rib)
            addBox(model_, world, {1.95 + rib * 0.08, kDepth - 0.13, 0.14}, {2.01 + rib * 0.08, kDepth - 0.04, 0.70},
                   metal);
    }

    void addLamp() {
        const int shade =
            addMaterial(model_, {Pattern::plain, reflectance(0xf3e2c0), {}, 1, 0, glm::dvec3(0.46, 0.38, 0.27)});
        const int cord = addMaterial(model_, {Pattern::plain, glm::dvec3(0.03)});
        const glm::dvec3 over(tableX_, tableY_, 0);
        addTube(model_, over + glm::dvec3(0, 0, 2.02), over + glm::dvec3(0, 0, kHeight), 0.006, cord);
        addTube(model_, over + glm::dvec3(0, 0, 1.86), over + glm::dvec3(0, 0, 2.02), 0.22, shade);
        addDisc(model_, over + glm::dvec3(0, 0, 2.02), {0, 0, 1}, 0.22, cord);
        addDisc(model_, over + glm::dvec3(0, 0, 1.87), {0, 0, -1}, 0.219, shade);
        model_.lamps.push_back(
            {over + glm::dvec3(-0.18, -0.18, 1.855), {0, 0.36, 0}, {0.36, 0, 0}, glm::dvec3(5.0, 4.3, 3.3), false});
    }

    void addFurniture() {
        const int seat = addMaterial(model_, {Pattern::weave, reflectance(0x3c5a4a), reflectance(0x6f8f78), 1.0, 41});
        const int sofa = addMaterial(model_, {Pattern::weave, reflectance(0x4a5a70), reflectance(0x7b8ba0), 1.0, 42});
        const int pillow =
            addMaterial(model_, {Pattern::checker, reflectance(0xd8b04a), reflectance(0xf2ead8), 0.07, 43});
        const Pose table = standing({tableX_, tableY_, 0}, random_.between(-0.04, 0.04));
        addTable(model_, table, {1.5, 0.86, 0.75}, oak_);
        for (const double x : {-0.38, 0.38}) {
            addChair(model_,
                     table *
                         standing({x + random_.between(-0.03, 0.03), -0.42, 0}, 3.1416 + random_.between(-0.15, 0.15)),
                     oak_, seat);
            addChair(model_,
                     table * standing({x + random_.between(-0.03, 0.03), 0.42, 0}, random_.between(-0.15, 0.15)), oak_,
                     seat);
        }
        addTableware(table);
        addSofa(model_, standing({3.05, 0.50, 0}, 3.141592653589793), 2.1, sofa, pillow);
        addBookcase(model_, standing({kWidth - 0.34, 2.35, 0}, -1.5707963267948966), {1.7, 0.32, 2.05}, dark_, random_);
        const int rug = addMaterial(model_, {Pattern::rug, reflectance(0x8f2f2a), reflectance(0xe0c9a0), 0.95, 44});
        addBox(model_, standing({3.1, 1.72, 0}, 0.05), {-0.95, -0.627, 0.0005}, {0.95, 0.627, 0.012}, rug);
        Patch& top = model_.patches[model_.patches.size() - 2];
        const glm::dvec2 middle = top.extent.high / 2.0; // the ornament is about the rug's middle
        top.origin += top.u * middle.x + top.v * middle.y;
        for (glm::dvec2& corner : top.outline)
            corner -= middle;
        top.extent = {-middle, middle};
        addPottedPlant(model_, {kWidth - 0.55, kDepth - 0.50, 0}, 1.45, random_);

        const Pose corner = standing({kWidth - 0.45, 0.62, 0}, 0.3);
        addBox(model_, corner, {-0.17, -0.17, 0}, {0.17, 0.17, 0.80}, white_);
        const int marble =
            addMaterial(model_, {Pattern::mottled, reflectance(0x2d5f73), reflectance(0xd9e4e2), 0.16, 45});
        addSphere(model_, corner * glm::dvec3(0, 0, 0.98), 0.18, marble);
    }

    void addTableware(const Pose& table) {
        const int bowl =
            addMaterial(model_, {Pattern::mottled, reflectance(0x3a6ea5), reflectance(0xdce8f0), 0.03, 51});
        addTube(model_, table * glm::dvec3(0.05, 0.02, 0.75), table * glm::dvec3(0.05, 0.02, 0.81), 0.15, bowl);
        const std::uint32_t fruit[] = {0xd98b1f, 0xc7402d, 0x9bb03a, 0xd98b1f, 0xe0b52d};
        for (int i = 0; i < 5; ++i) {
            const int skin =
                addMaterial(model_, {Pattern::mottled, reflectance(fruit[i]), reflectance(fruit[i]) * 0.7, 0.03, 52});
            const double angle = i * 1.2566, radius = 0.038 + 0.002 * i;
            addSphere(model_, table * glm::dvec3(0.05 + 0.085 * std::cos(angle), 0.02 + 0.085 * std::sin(angle), 0.805),
                      radius, skin);
        }
        for (const double x : {-0.45, 0.48}) {
            const double y = x < 0 ? -0.22 : 0.2;
            addTube(model_, table * glm::dvec3(x, y, 0.75), table * glm::dvec3(x, y, 0.845), 0.04, bowl);
            addDisc(model_, table * glm::dvec3(x, y, 0.82), {0, 0, 1}, 0.0399, dark_);
        }
        const int paper = addMaterial(model_, {Pattern::chart, {}, {}, 0.21, 53});
        addBox(model_, table * standing({-0.52, 0.12, 0}, 0.3), {-0.105, -0.14, 0.7505}, {0.105, 0.14, 0.762}, paper);
        const int cover = addMaterial(model_, {Pattern::spine, reflectance(0x8c2f2b), reflectance(0xe3d3a0), 0.22, 54});
        addBox(model_, table * standing({0.46, -0.18, 0}, -0.4), {-0.08, -0.11, 0.7505}, {0.08, 0.11, 0.785}, cover);
    }

    /// A framed picture on a wall: lower left corner, to the right along the wall, both seen from within the
    /// room.
    void addPicture(const glm::dvec3& corner, const glm::dvec3& right, double width, double height, Pattern pattern,
                    std::uint32_t seed) {
        const glm::dvec3 up(0, 0, 1), in = glm::cross(right, up);
        const Pose wall{glm::dmat3(right, -in, up), corner};
        const int art = addMaterial(model_, {pattern, {}, {}, width, seed});
        const double f = 0.04;
        addBox(model_, wall, {-f, -0.03, -f}, {width + f, -0.0005, 0}, dark_);
        addBox(model_, wall, {-f, -0.03, height}, {width + f, -0.0005, height + f}, dark_);
        addBox(model_, wall, {-f, -0.03, 0}, {0, -0.0005, height}, dark_);
        addBox(model_, wall, {width, -0.03, 0}, {width + f, -0.0005, height}, dark_);
        addRectangle(model_, wall * glm::dvec3(0, -0.012, 0), right * width, up * height, art);
    }

    void addWalls() {
        addPicture({3.80, 0, 1.30}, {-1, 0, 0}, 1.45, 0.88, Pattern::picture, 61);
        addPicture({0, 1.75, 1.15}, {0, 1, 0}, 0.62, 0.81, Pattern::chart, 62);
        addPicture({0, 2.75, 1.28}, {0, 1, 0}, 0.80, 0.55, Pattern::picture, 63);
        addPicture({kWidth, 1.28, 1.30}, {0, -1, 0}, 0.42, 0.54, Pattern::picture, 64);
        const Pose world;
        const int door = addMaterial(model_, {Pattern::door, reflectance(0x6e4a2c), reflectance(0x8f6740), 0.86, 65});
        addRectangle(model_, {0.012, 0.35, 0.005}, {0, 0.86, 0}, {0, 0, 2.03}, door);
        addBox(model_, world, {0.0005, 0.28, 0}, {0.025, 0.35, 2.10}, white_);
        addBox(model_, world, {0.0005, 1.21, 0}, {0.025, 1.28, 2.10}, white_);
        addBox(model_, world, {0.0005, 0.35, 2.035}, {0.025, 1.21, 2.10}, white_);
        const int clock = addMaterial(model_, {Pattern::dial, reflectance(0xe9e2d0), {}, 0.16, 66});
        addDisc(model_, {0.7, 0.03, 1.75}, {0, 1, 0}, 0.16, clock);
        addTube(model_, {0.7, 0.0005, 1.75}, {0.7, 0.035, 1.75}, 0.165, dark_);
        const int cabinet =
            addMaterial(model_, {Pattern::grain, reflectance(0x9a6a3d), reflectance(0xcfa06a), 1.0, 67});
        addBox(model_, world, {0.30, 0.016, 0.08}, {1.35, 0.42, 0.78}, cabinet);
        addBox(model_, world, {0.34, 0.05, 0}, {1.31, 0.40, 0.08}, dark_);
        for (const double x : {0.34, 0.845})
            addBox(model_, world, {x, 0.4205, 0.12}, {x + 0.465, 0.432, 0.74}, cabinet);
        for (const double x : {0.76, 0.89})
            addSphere(model_, {x, 0.445, 0.45}, 0.016, dark_);
        const int vase =
            addMaterial(model_, {Pattern::mottled, reflectance(0x2f6f62), reflectance(0xcfe0c8), 0.05, 68});
        addSphere(model_, {1.1, 0.22, 0.78 + 0.11}, 0.11, vase);
        addTube(model_, {1.1, 0.22, 0.97}, {1.1, 0.22, 1.10}, 0.035, vase);
        addBox(model_, standing({0.58, 0.22, 0}, 0.2), {-0.14, -0.09, 0.7805}, {0.14, 0.09, 0.82},
               addMaterial(model_, {Pattern::spine, reflectance(0x27496d), reflectance(0xd9d2c0), 0.18, 69}));
    }

    void addPaths() {
        const glm::dvec3 table(tableX_, tableY_, 0.8), shelf(kWidth - 0.3, 2.3, 1.2), window(2.5, kDepth, 1.5),
            sofa(3.05, 0.4, 0.8);
        model_.walk = {{{0.75, 0.95, 1.6}, table}, {{1.9, 1.05, 1.6}, window}, {{3.1, 1.35, 1.6}, shelf},
                       {{3.95, 1.7, 1.6}, shelf},  {{4.05, 2.7, 1.6}, window}, {{3.4, 3.3, 1.6}, table},
                       {{2.2, 3.55, 1.6}, sofa},   {{0.95, 3.4, 1.6}, sofa},   {{0.42, 2.6, 1.6}, table},
                       {{0.45, 1.6, 1.6}, sofa}};
        model_.tripods = {{3.2, 2.45, 1.5}, {0.5, 1.35, 1.6}, {4.0, 1.4, 1.45}, {0.8, 3.6, 1.55}};
    }

    SyntheticModel model_;
    SeededSequence random_;
    int white_ = 0, oak_ = 0, dark_ = 0;
    double left_ = 1.7, right_ = 3.5, sill_ = 0.88, lintel_ = 2.28;
    double tableX_ = 1.72, tableY_ = 2.35;
};

} // namespace

SyntheticScene makeRoom(std::uint32_t seed) {
    return SyntheticScene(Room(seed).build());
}

} // namespace scene
