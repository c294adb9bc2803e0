// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

package main

import (
	"bytes"
	"compress/zlib"
	"context"
	"io"
	"log"
	"math"

	"latticed/v1"
)

const (
	unknownBound = 255
	mostLevel    = 5
)

// plan is a patch plan without normals, of a mesh inside the frame.
type plan struct {
	header  *v1.PatchPlanHeader
	corners [][3]int   // vertices of each patch
	places  [][3]int64 // of each vertex
}

// planes reads arrays of unsigned integers whose lowest bytes come first, then the next bytes of all.
type planes struct{ left []byte }

func (p *planes) take(count, width int) []int64 {
	if len(p.left) < count*width {
		log.Fatal("a run of patches is too short")
	}
	numbers := make([]int64, count)
	for b := 0; b < width; b++ {
		for i := range numbers {
			numbers[i] |= int64(p.left[b*count+i]) << (8 * b)
		}
	}
	p.left = p.left[count*width:]
	return numbers
}

func (p *plan) takeRun(run *v1.PatchRun) {
	if int(run.FirstPatch) != len(p.corners) {
		log.Fatal("a run of patches does not begin where the one before ends")
	}
	stream, err := zlib.NewReader(bytes.NewReader(run.Data))
	check(err)
	data, err := io.ReadAll(stream)
	check(err)
	arrays := planes{data}
	known := len(p.places)
	var corner [3]int
	for i, c := range arrays.take(3*int(run.Patches), 4) {
		corner[i%3] = known - int(c)
		if c == 0 {
			known++
		}
		if i%3 == 2 {
			p.corners = append(p.corners, corner)
		}
	}
	fresh := int(run.NewVertices)
	if known != len(p.places)+fresh {
		log.Fatalf("a run has %d new vertices instead of %d", known-len(p.places), fresh)
	}
	differences := arrays.take(3*fresh, 4)
	first := len(p.places)
	p.places = append(p.places, make([][3]int64, fresh)...)
	for axis := 0; axis < 3; axis++ {
		place := int64(0)
		for i, d := range differences[axis*fresh : (axis+1)*fresh] {
			if d%2 == 0 {
				place += d / 2
			} else {
				place -= (d + 1) / 2
			}
			p.places[first+i][axis] = place
		}
	}
	if len(arrays.left) != 0 {
		log.Fatalf("a run has %d bytes too many", len(arrays.left))
	}
}

func getPlan(ctx context.Context, scenes v1.SceneServiceClient, scene, topology string) *plan {
	stream, err := scenes.GetPatchPlan(ctx, &v1.GetPatchPlanRequest{
		Scene: scene, TopologyId: topology, Normals: v1.NormalMode_NORMAL_MODE_NONE})
	check(err)
	made := &plan{}
	for {
		part, err := stream.Recv()
		if err == io.EOF {
			break
		}
		check(err)
		if part.GetHeader() != nil {
			made.header = part.GetHeader()
		} else if part.GetRun() != nil {
			made.takeRun(part.GetRun())
		}
	}
	header := made.header
	complete := int(header.PatchCount) == len(made.corners) && int(header.VertexCount) == len(made.places)
	if !complete || header.PatchesOutside != 0 || header.NormalCount != 0 {
		log.Fatalf("the plan is not that of its header: %v", header)
	}
	return made
}

// edges returns the edges of each patch, numbered by first use, and their number.
func (p *plan) edges() ([][3]int, int) {
	numbers := map[[2]int]int{}
	all := make([][3]int, len(p.corners))
	for i, corners := range p.corners {
		for e := range corners {
			a, b := corners[e], corners[(e+1)%3]
			if a > b {
				a, b = b, a
			}
			if _, known := numbers[[2]int{a, b}]; !known {
				numbers[[2]int{a, b}] = len(numbers)
			}
			all[i][e] = numbers[[2]int{a, b}]
		}
	}
	return all, len(numbers)
}

// levelOf returns the least level of an edge that keeps the tolerance.
func (p *plan) levelOf(edge byte, tolerance float64) uint32 {
	for level := uint32(0); level < mostLevel; level++ {
		bound := p.header.CurvatureUnit * math.Pow(2, float64(edge)/2)
		if edge != unknownBound && bound <= 6*tolerance*math.Pow(4, float64(level)) {
			return level
		}
	}
	return mostLevel
}
