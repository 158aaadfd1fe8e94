// Captures two linked capsules that fall to the floor, from MuJoCo; or a model file: ./mujoco_capture fall.scenes robot.xml
// g++ mujoco.cpp -o mujoco_capture -lmujoco && ./mujoco_capture fall.scenes

#include <mujoco/mujoco.h>

#include <cstdio>
#include <string>
#include <vector>

#include "capture.h"

static const char* kModel =
    "<mujoco><option timestep='0.005'/><worldbody><geom type='plane' size='5 5 1'/>"
    "<body pos='0 0 0.5'><freejoint/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.05'/>"
    "<body pos='0.3 0 0'><joint axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.2 0 0.2' size='0.04'/>"
    "</body></body></worldbody></mujoco>";

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string file = argc > 2 ? argv[2] : std::string(argv[1]) + ".xml";
  if (argc == 2) {
    std::FILE* text = std::fopen(file.c_str(), "w");
    if (text == nullptr) return 1;
    std::fputs(kModel, text);
    std::fclose(text);
  }
  char error[1000] = "";
  mjModel* m = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
  if (argc == 2) std::remove(file.c_str());
  if (m == nullptr) return std::fprintf(stderr, "%s\n", error), 1;
  mjData* d = mj_makeData(m);
  const int nv = m->nv;
  const double h = m->opt.timestep;
  lcpbench_capture* capture = lcpbench_capture_open(argv[1], "linked capsules falling", "MuJoCo", mj_versionString(), h);
  if (capture == nullptr) return 1;
  lcpbench_capture_loop(capture, "engine");
  std::vector<double> G(static_cast<std::size_t>(nv * nv)), v(static_cast<std::size_t>(nv));
  std::vector<int> coordinates;
  for (int i = 0; i < nv; ++i) coordinates.push_back(i);
  for (int step = 0; step < 120; ++step) {
    mj_forward(m, d);
    mj_fullM(m, G.data(), d->qM);
    for (int i = 0; i < nv; ++i) v[i] = d->qvel[i] + h * d->qacc_smooth[i];  // without contacts
    lcpbench_capture_step(capture, step, d->time);
    lcpbench_capture_block(capture, nv, G.data(), v.data());
    for (int c = 0; c < d->ncon; ++c) {
      const mjContact& contact = d->contact[c];
      std::vector<double> first(3 * nv), second(3 * nv), rows(3 * nv);
      mj_jac(m, d, first.data(), nullptr, contact.pos, m->geom_bodyid[contact.geom1]);
      mj_jac(m, d, second.data(), nullptr, contact.pos, m->geom_bodyid[contact.geom2]);
      for (int i = 0; i < 3 * nv; ++i) second[i] -= first[i];  // the normal points into the second geometry
      mju_mulMatMat(rows.data(), contact.frame, second.data(), 3, 3, nv);
      const double offset = contact.dist > 0 ? contact.dist / h : 0.0;
      const int index = lcpbench_capture_rows(capture, nv, coordinates.data(), &rows[0], &rows[nv], &rows[2 * nv],
                                              contact.friction[0], 8, offset, nullptr);
      lcpbench_capture_gap(capture, index, contact.dist);
    }
    lcpbench_capture_end_step(capture);
    mj_step(m, d);
  }
  mj_deleteData(d);
  mj_deleteModel(m);
  return lcpbench_capture_close(capture) == 0 ? 0 : 1;
}
