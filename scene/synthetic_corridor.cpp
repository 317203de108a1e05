// The corridor of scene/synthetic.h: along x, doors on both sides between pillars; what repeats repeats
// exactly.

#include "scene/synthetic.h"

#include "scene/synthetic_furniture.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr double kLength = 26.0, kCorridorWidth = 2.6, kCorridorHeight = 2.9, kBay = 3.25; // metres
constexpr int kBays = 8;

class Corridor {
  public:
    explicit Corridor(std::uint32_t seed) : random_(seed) {
        model_.name = "corridor";
        model_.lightSpacing = 0.13;
        model_.exposure = 3.0;
        model_.sky.towardsSun = glm::normalize(glm::dvec3(0.86, -0.30, 0.36));
        model_.sky.sun = glm::dvec3(4.2, 3.8, 3.1);
        model_.sky.zenith = glm::dvec3(0.5, 0.9, 1.6);
        model_.sky.horizon = glm::dvec3(1.7, 1.8, 1.9);
        model_.sky.seed = seed;
    }

    SyntheticModel build() {
        addShell();
        for (int bay = 0; bay < kBays; ++bay)
            addBay(bay);
        addEnds();
        addThings();
        for (const double x : {1.3, 4.4, 8.0, 12.0, 16.0, 20.0, 23.2, 24.4})
            model_.walk.push_back({{x, 0.22 * std::sin(x * 0.7), 1.6}, {x + 3.0, 1.1 * std::sin(x * 1.3), 1.4}});
        model_.walkIsLoop = false;
        for (const double x : {2.0, 8.0, 14.5, 21.0})
            model_.tripods.push_back({x, 0.15 * std::sin(x), 1.55});
        return std::move(model_);
    }

  private:
    void addShell() {
        const double y = kCorridorWidth / 2;
        const int floor = addMaterial(model_, {Pattern::tiles, reflectance(0xb9b2a2), reflectance(0x6e675c), 0.40, 71});
        const int wall = addMaterial(model_, {Pattern::plaster, reflectance(0xe2dccb)});
        const int ceiling =
            addMaterial(model_, {Pattern::tiles, reflectance(0xe9e7e0), reflectance(0xa5a39c), 0.65, 72});
        const int dado = addMaterial(model_, {Pattern::plaster, reflectance(0x6f8f86)});
        addRectangle(model_, {0, -y, 0}, {kLength, 0, 0}, {0, kCorridorWidth, 0}, floor);
        addRectangle(model_, {0, -y, kCorridorHeight}, {0, kCorridorWidth, 0}, {kLength, 0, 0}, ceiling);
        addRectangle(model_, {kLength, -y, 0}, {-kLength, 0, 0}, {0, 0, kCorridorHeight}, wall);
        addRectangle(model_, {0, y, 0}, {kLength, 0, 0}, {0, 0, kCorridorHeight}, wall);
        rail_ = addMaterial(model_, {Pattern::grain, reflectance(0x6b4a2e), reflectance(0xa3774b), 1.0, 73});
        dado_ = dado;
    }

    /// Pillars at the start of each bay, a door and a panel on each side, a lamp in the ceiling.
    void addBay(int bay) {
        const Pose world;
        const double x = bay * kBay, y = kCorridorWidth / 2;
        const int stone = bay == 0 ? stone_ = addMaterial(model_, {Pattern::mottled, reflectance(0xb8b0a0),
                                                                   reflectance(0xd8d2c4), 0.25, 74})
                                   : stone_;
        for (const double side : {-1.0, 1.0}) {
            const double in = side * (y - 0.14), wall = side * y;
            addBox(model_, world, {x + 0.02, std::min(in, wall), 0}, {x + 0.36, std::max(in, wall), kCorridorHeight},
                   stone);
            addBox(model_, world, {x, std::min(in - side * 0.02, wall), 0},
                   {x + 0.38, std::max(in - side * 0.02, wall), 0.16}, rail_);
            addBox(model_, world, {x, std::min(in - side * 0.02, wall), kCorridorHeight - 0.22},
                   {x + 0.38, std::max(in - side * 0.02, wall), kCorridorHeight - 0.12}, rail_);
            addDoor(bay, side);
            // Dado panels left and right of the door, with a rail on top.
            for (const glm::dvec2 span : {glm::dvec2(x + 0.39, x + 0.90), glm::dvec2(x + 2.06, x + kBay)}) {
                const double skin = wall - side * 0.016, rail = wall - side * 0.04;
                addBox(model_, world, {span.x, std::min(skin, wall), 0}, {span.y, std::max(skin, wall), 0.95}, dado_);
                addBox(model_, world, {span.x, std::min(rail, wall), 0.95}, {span.y, std::max(rail, wall), 1.01},
                       rail_);
                addBox(model_, world, {span.x, std::min(rail, wall), 0}, {span.y, std::max(rail, wall), 0.10}, rail_);
            }
        }
        const int lit =
            bay == 0
                ? lit_ = addMaterial(model_, {Pattern::plain, glm::dvec3(0.8), {}, 1, 0, glm::dvec3(2.2, 2.15, 2.0)})
                : lit_;
        const int frame = bay == 0 ? frame_ = addMaterial(model_, {Pattern::plain, glm::dvec3(0.55)}) : frame_;
        const double middle = x + 1.8;
        addBox(model_, world, {middle - 0.62, -0.17, kCorridorHeight - 0.055}, {middle + 0.62, 0.17, kCorridorHeight},
               frame);
        addRectangle(model_, {middle - 0.60, -0.15, kCorridorHeight - 0.056}, {0, 0.30, 0}, {1.20, 0, 0}, lit);
        model_.lamps.push_back({{middle - 0.60, -0.15, kCorridorHeight - 0.058},
                                {0, 0.30, 0},
                                {1.20, 0, 0},
                                glm::dvec3(6.4, 6.1, 5.4),
                                false});
    }

    void addDoor(int bay, double side) {
        const Pose world;
        const double x = bay * kBay + 1.0, wall = side * kCorridorWidth / 2, leafY = wall - side * 0.02;
        const bool isLeft = side > 0;
        Material wood{Pattern::door, reflectance(0x74502f), reflectance(0x9a7146), 0.96, 75};
        if (doorMaterial_ < 0) doorMaterial_ = addMaterial(model_, wood);
        const glm::dvec3 along(isLeft ? 1.0 : -1.0, 0, 0);
        addRectangle(model_, {isLeft ? x : x + 0.96, leafY, 0.005}, along * 0.96, {0, 0, 2.1}, doorMaterial_);
        const double jamb = wall - side * 0.05;
        for (const double at : {x - 0.07, x + 0.96})
            addBox(model_, world, {at, std::min(jamb, wall), 0}, {at + 0.07, std::max(jamb, wall), 2.17}, rail_);
        addBox(model_, world, {x, std::min(jamb, wall), 2.105}, {x + 0.96, std::max(jamb, wall), 2.17}, rail_);
        const auto number = static_cast<std::uint32_t>(101 + 2 * bay + (isLeft ? 0 : 1));
        const int plate =
            addMaterial(model_, {Pattern::number, reflectance(0xe8e4d8), reflectance(0x20303c), 0.26, number});
        const double plateX = isLeft ? x + 1.12 : x - 0.16;
        addRectangle(model_, {plateX, wall - side * 0.008, 1.55}, along * 0.26, {0, 0, 0.155}, plate);
    }

    /// One end is a window to the sky, the other a wall with a double door.
    void addEnds() {
        const double y = kCorridorWidth / 2;
        const Pose world;
        const int wall = addMaterial(model_, {Pattern::plaster, reflectance(0xd7c9a8)});
        const int paint = addMaterial(model_, {Pattern::plain, reflectance(0xf0eee8)});
        addRectangle(model_, {kLength, y, 0}, {0, -kCorridorWidth, 0}, {0, 0, kCorridorHeight}, wall,
                     {{{0.45, 0.9}, {kCorridorWidth - 0.45, 2.5}}});
        addRectangle(model_, {0, -y, 0}, {0, kCorridorWidth, 0}, {0, 0, kCorridorHeight}, wall);
        const double z0 = 0.9, z1 = 2.5, w = y - 0.45;
        addBox(model_, world, {kLength + 0.0005, -w - 0.3, z0 - 0.3}, {kLength + 0.2, w + 0.3, z0}, paint);
        addBox(model_, world, {kLength + 0.0005, -w - 0.3, z1}, {kLength + 0.2, w + 0.3, z1 + 0.3}, paint);
        for (const double side : {-1.0, 1.0})
            addBox(model_, world, {kLength + 0.0005, side > 0 ? w : -w - 0.3, z0},
                   {kLength + 0.2, side > 0 ? w + 0.3 : -w, z1}, paint);
        for (const double at : {-w, -0.03, w - 0.06})
            addBox(model_, world, {kLength + 0.07, at, z0}, {kLength + 0.12, at + 0.06, z1}, paint);
        addBox(model_, world, {kLength + 0.072, -w, 1.95}, {kLength + 0.118, w, 2.01}, paint);
        model_.lamps.push_back({{kLength, -w, z0}, {0, 0, z1 - z0}, {0, 2 * w, 0}, {}, true});
        const int door = addMaterial(model_, {Pattern::door, reflectance(0x35505a), reflectance(0x4f6f78), 0.8, 76});
        addRectangle(model_, {0.02, -0.80, 0.005}, {0, 0.80, 0}, {0, 0, 2.1}, door);
        addRectangle(model_, {0.02, 0.004, 0.005}, {0, 0.80, 0}, {0, 0, 2.1}, door);
        for (const double at : {-0.90, 0.808})
            addBox(model_, world, {0.0005, at, 0}, {0.05, at + 0.09, 2.2}, rail_);
        addBox(model_, world, {0.0005, -0.80, 2.11}, {0.05, 0.80, 2.2}, rail_);
    }

    /// The few things that are there only once.
    void addThings() {
        const double y = kCorridorWidth / 2;
        const int red = addMaterial(model_, {Pattern::plain, reflectance(0xb3201c)});
        const int black = addMaterial(model_, {Pattern::plain, glm::dvec3(0.02)});
        for (const double x : {6.02, 18.95}) {
            const double side = x < 10 ? 1.0 : -1.0, at = side * (y - 0.13);
            addTube(model_, {x, at, 0.62}, {x, at, 1.05}, 0.075, red);
            addSphere(model_, {x, at, 1.05}, 0.075, red);
            addDisc(model_, {x, at, 0.62}, {0, 0, -1}, 0.075, red);
            addRod(model_, {x, at, 1.12}, {x, at, 1.18}, 0.02, black);
            addRod(model_, {x, at, 1.17}, {x + 0.10, at, 1.15}, 0.012, black);
        }
        const int wood = addMaterial(model_, {Pattern::planks, reflectance(0x9a7146), reflectance(0xc79a63), 0.11, 77});
        const Pose bench = standing({9.05, -y + 0.34, 0}, 0);
        addBox(model_, bench, {-0.55, -0.18, 0.41}, {0.55, 0.18, 0.45}, wood);
        for (const double x : {-0.45, 0.45})
            addBox(model_, bench, {x - 0.03, -0.15, 0}, {x + 0.03, 0.15, 0.41}, black);
        addPottedPlant(model_, {15.55, y - 0.36, 0}, 1.25, random_);
        addPottedPlant(model_, {kLength - 0.45, -y + 0.40, 0}, 1.3, random_);
        const std::uint32_t seeds[] = {81, 82, 83, 84};
        for (int i = 0; i < 4; ++i) {
            const double x = 2.35 + kBay * (2 * i + (i > 1 ? 1 : 0)), side = i % 2 == 0 ? -1.0 : 1.0;
            const glm::dvec3 along(side > 0 ? 1.0 : -1.0, 0, 0);
            const double width = i == 2 ? 0.60 : 0.80, height = i == 2 ? 0.78 : 0.55;
            const int art = addMaterial(model_, {i == 2 ? Pattern::chart : Pattern::picture, {}, {}, width, seeds[i]});
            const Pose world;
            const double wall = side * y, front = wall - side * 0.03;
            addBox(model_, world, {x - 0.03, std::min(wall, front), 1.22},
                   {x + width + 0.03, std::max(wall, front), 1.28 + height}, black);
            addRectangle(model_, {side > 0 ? x : x + width, front - side * 0.001, 1.25}, along * width, {0, 0, height},
                         art);
        }
        const int sign = addMaterial(model_, {Pattern::stripes, reflectance(0x1c7a45), reflectance(0xe8f3ea), 0.06, 0,
                                              glm::dvec3(0.02, 0.2, 0.08)});
        addBox(model_, Pose{}, {kLength - 1.5, -0.20, 2.55}, {kLength - 1.46, 0.20, 2.72}, sign);
        addRod(model_, {kLength - 1.48, 0, 2.72}, {kLength - 1.48, 0, kCorridorHeight}, 0.01, black);
    }

    SyntheticModel model_;
    SeededSequence random_;
    int rail_ = 0, dado_ = 0, stone_ = 0, lit_ = 0, frame_ = 0, doorMaterial_ = -1;
};

} // namespace

SyntheticScene makeCorridor(std::uint32_t seed) {
    return SyntheticScene(Corridor(seed).build());
}

} // namespace scene
