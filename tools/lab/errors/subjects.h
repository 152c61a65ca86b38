/* SPDX-License-Identifier: MIT */
/* The subjects of this room, for the list in program/subjects.c. */
#ifndef SVOCL_TOOLS_ERRORS_SUBJECTS_H
#define SVOCL_TOOLS_ERRORS_SUBJECTS_H

#include "measure/suite.h"

/* E1: voxelization. Table "e1-voxelization". */
extern const suite_subject errors_voxelization;
/* E2: rays. Tables "e2-rays" and "e2-input". */
extern const suite_subject errors_rays;
/* E3: attributes. Table "e3-attributes". */
extern const suite_subject errors_attributes;
/* E4: level of detail. Table "e4-detail". */
extern const suite_subject errors_detail;
/* E5: ill-conditioned meshes. Table "e5-conditioning". */
extern const suite_subject errors_conditioning;
/* E7: cones. Tables "e7-cones", "e7-directions" and "e7-alternatives". */
extern const suite_subject errors_cones;
/* E8: light field probes. Tables "e8-probes", "e8-choices" and "e8-light". */
extern const suite_subject errors_probes;

#endif
