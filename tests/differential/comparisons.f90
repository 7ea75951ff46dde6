!> Channels of two runs of a scene side by side, and how far they may be apart.
module comparisons
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text
   use couplings, only: places, angles, speeds, spins, accelerations, forces, moments, stresses, deflections, energies, &
      & rotations, powers, others
   use drafts, only: draft_type
   use pardons, only: pardoned, keeps_up
   use plans, only: small_change, number_of_integrator
   use trials, only: candidate_type
   use views, only: view_type
   implicit none
   private
   public :: verdict_type, scales_type, find_scales, compare, allowed_by

   !> Multiple of the tolerance that channels may be off, relative to what they are and how they answer to changes of the scene
   real(wp), parameter :: allowed(5) = [300.0_wp, 300.0_wp, 300.0_wp, 1000.0_wp, 1000.0_wp]
   !> What a channel of each group counts as at least
   real(wp), parameter :: floors(14) = [1.0e-3_wp, 1.0e-3_wp, 1.0e-2_wp, 1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp, &
      & 1.0e-6_wp, 3.0e-4_wp, 1.0e3_wp, 1.0e-3_wp, 1.0e-3_wp, 1.0e-3_wp]
   !> The same of accelerations and forces where bodies vibrate, and of accelerations at rest: what the weight makes of the shapes
   !> of bodies, two or three times its own at a free end, is what limber compares vibrations with there
   real(wp), parameter :: elastic_acceleration = 10.0_wp, resting_acceleration = 30.0_wp
   real(wp), parameter :: elastic_force = 1.0_wp, elastic_moment = 0.1_wp, elastic_stress = 1.0e4_wp
   !> The same where what stands still is run: limber's own scales, a thousandth of a body's length for deflections and the scene
   !> crossed once in the time of the run for speeds
   integer, parameter :: resting(7) = [speeds, spins, deflections, rotations, powers, others, others + 1]
   real(wp), parameter :: of_rest(7) = [5.0_wp, 5.0_wp, 5.0e-4_wp, 1.0e-3_wp, 1.0e3_wp, 5.0_wp, 5.0_wp]
   !> Speeds and spins of what stands still
   real(wp), parameter :: still = 1.0e-9_wp
   !> Part of the largest of its group that accelerations, reactions and section forces of elastic bodies may be off by an
   !> integrator that does not follow their vibrations, or keeps them up at rest: from there on limber warns
   real(wp), parameter :: unseen = 1.0e-2_wp
   !> Part of the largest of its group that a channel counts as at least
   real(wp), parameter :: part_of_group = 0.05_wp

   !> What errors of the channels are relative to (channels), and the largest of the group of each
   type :: scales_type
      real(wp), allocatable :: own(:), of_group(:)
      !> The same of the envelope
      real(wp) :: envelope(3) = 0.0_wp
      !> Whether nothing moves; whether that is so or nothing is loaded that vibrates: forces and accelerations are round-off then
      logical :: stands = .false., idle = .false.
   end type scales_type

   !> What came out
   type :: verdict_type
      !> `same`, `refused`, `failed`, `warned` (different, by no more than a warning excuses), `estimated` (as different as is
      !> estimated), or else a disagreement: `values`, `status`, `warnings`, `slow`
      character(10) :: kind = 'same'
      !> View that disagrees, and on what
      character(24) :: view = ''
      character(200) :: what = ''
      !> How far, in units of what is allowed
      real(wp) :: ratio = 0.0_wp
   end type verdict_type

contains

   !> What errors of each channel are relative to: its size, a part of that of its group, and its answer to a change.
   subroutine find_scales(draft, reference, changed, scales)
      type(draft_type), intent(in) :: draft
      type(candidate_type), intent(in) :: reference, changed
      type(scales_type), intent(out) :: scales
      real(wp) :: largest(size(floors)), lowest(size(floors))
      integer, allocatable :: group(:)
      integer :: i, row, k
      logical :: answers
      allocate (scales%own(size(reference%values, 1)), scales%of_group(size(reference%values, 1)), &
         & group(size(reference%values, 1)))
      largest = 0.0_wp
      row = 0
      do i = 1, size(draft%channels)
         do k = 1, merge(2, 1, allocated(draft%channels(i)%second))
            row = row + 1
            group(row) = draft%channels(i)%group
            associate (values => reference%values(row, :))
               if (size(values) == 0) cycle
               scales%own(row) = maxval(abs(values))
               if (any(group(row) == [places, angles])) scales%own(row) = maxval(abs(values - values(1)))
            end associate
            largest(group(row)) = max(largest(group(row)), scales%own(row))
         end do
      end do
      lowest = floors
      if (draft%elastic) lowest(accelerations) = elastic_acceleration
      if (draft%elastic) lowest(forces) = elastic_force
      if (draft%elastic) lowest(moments) = elastic_moment
      if (draft%elastic) lowest(stresses) = elastic_stress
      scales%stands = draft%timeless .or. max(largest(speeds), largest(spins)) < still
      if (scales%stands) lowest(resting) = of_rest
      if (scales%stands .and. draft%elastic) lowest(accelerations) = resting_acceleration
      scales%idle = scales%stands .or. (draft%elastic .and. largest(accelerations) < lowest(accelerations) .and. &
         & largest(forces) < lowest(forces) .and. largest(moments) < lowest(moments))
      ! Deflections at rest are known to their own scale, and energies to the work of the forces along it
      if (scales%stands) lowest(energies) = max(lowest(energies), largest(forces)*of_rest(3))
      answers = changed%status == 0 .and. all(shape(changed%values) == shape(reference%values))
      scales%envelope = max(reference%envelope, [10*elastic_force, elastic_force, elastic_moment], &
         & part_of_group*largest([forces, forces, moments]))
      if (answers) scales%envelope = scales%envelope + abs(changed%envelope - reference%envelope)/small_change
      do row = 1, size(scales%own)
         scales%of_group(row) = max(largest(group(row)), lowest(group(row)))
         scales%own(row) = max(scales%own(row), part_of_group*largest(group(row)), lowest(group(row)))
         if (answers) scales%own(row) = scales%own(row) + &
            & maxval(abs(changed%values(row, :) - reference%values(row, :)))/small_change
      end do
   end subroutine find_scales

   !> Part of its scale that a channel of a view may be off without a word.
   pure real(wp) function allowed_by(view) result(part)
      type(view_type), intent(in) :: view
      part = view%tolerance*allowed(number_of_integrator(view%integrator))
   end function allowed_by

   !> Compares a run with the reference. What the warnings of either excuse is `warned`.
   subroutine compare(draft, view, trial, reference, scales, name, verdict)
      type(draft_type), intent(in) :: draft
      type(view_type), intent(in) :: view
      type(candidate_type), intent(in) :: trial, reference
      type(scales_type), intent(in) :: scales
      character(*), intent(in) :: name
      type(verdict_type), intent(inout) :: verdict
      real(wp) :: error, limit, excused
      integer :: i, k, row, at
      row = 0
      if (any(shape(trial%values) /= shape(reference%values))) then
         call disagree('values', 1.0_wp, 'another number of samples')
         return
      end if
      do i = 1, size(draft%channels)
         do k = 1, merge(2, 1, allocated(draft%channels(i)%second))
            row = row + 1
            if (draft%channels(i)%placed .and. any(abs(view%moved) > 0.0_wp)) cycle
            error = maxval(abs(trial%values(row, :) - reference%values(row, :)))
            limit = scales%own(row)*allowed_by(view)
            if (draft%elastic .and. (scales%stands .or. view%integrator /= 'ADAMS') .and. any(draft%channels(i)%group == &
               & [accelerations, forces, moments, stresses, powers])) limit = max(limit, unseen*scales%of_group(row))
            ! A vibration that is kept up at the limit of the steps is there in what stands still else
            if (keeps_up(trial%warnings) .or. keeps_up(reference%warnings)) limit = max(limit, allowed_by(view)* &
               & sum(of_rest, draft%channels(i)%group == resting))
            excused = max(pardoned(trial%warnings, draft%channels(i)%group), pardoned(reference%warnings, draft%channels(i)%group))
            if (error <= limit) then
               verdict%ratio = max(verdict%ratio, error/limit)
            else
               at = maxloc(abs(trial%values(row, :) - reference%values(row, :)), 1)
               call disagree(merge('warned', 'values', excused > 0.0_wp .and. error/scales%of_group(row) <= excused), error/limit, &
                  & trim(view%integrator)//' '//draft%channels(i)%first//' sample '//as_text(at)//': '// &
                  & as_text(trial%values(row, at), 6)//' for '//as_text(reference%values(row, at), 6)//', scale '// &
                  & as_text(scales%own(row), 3))
            end if
         end do
      end do
      call compare_envelopes()
      call compare_modes()

   contains

      !> Largest internal forces of the envelope.
      subroutine compare_envelopes()
         character(*), parameter :: names(3) = [character(14) :: 'axial force', 'shear force', 'bending moment']
         integer :: group
         do i = 1, 3
            group = merge(moments, forces, i == 3)
            error = abs(trial%envelope(i) - reference%envelope(i))
            limit = scales%envelope(i)*allowed_by(view)
            if (scales%stands .or. view%integrator /= 'ADAMS') limit = max(limit, unseen*max(elastic_force, &
               & maxval(reference%envelope(:2))))
            if (error <= limit) cycle
            excused = max(pardoned(trial%warnings, group), pardoned(reference%warnings, group))*scales%envelope(i)
            call disagree(merge('warned', 'values', excused >= error), error/limit, trim(view%integrator)//' envelope, '// &
               & trim(names(i))//': '//as_text(trial%envelope(i), 6)//' for '//as_text(reference%envelope(i), 6))
         end do
      end subroutine compare_envelopes

      !> Notes a difference, if it is worse than what is known.
      subroutine disagree(kind, ratio, what)
         character(*), intent(in) :: kind, what
         real(wp), intent(in) :: ratio
         if (verdict%kind == 'values' .and. (kind /= 'values' .or. ratio <= verdict%ratio)) return
         if (kind == verdict%kind .and. ratio <= verdict%ratio) return
         verdict%kind = kind
         verdict%view = name
         verdict%ratio = ratio
         verdict%what = what
      end subroutine disagree

      subroutine compare_modes()
         real(wp) :: largest, ratio
         integer :: m
         if (size(trial%modes, 2) /= size(reference%modes, 2)) then
            call disagree('values', 1.0_wp, 'another number of modes')
            return
         end if
         if (size(trial%modes, 2) == 0) return
         largest = maxval(reference%modes(1, :)**2)
         do m = 1, size(trial%modes, 2)
            ratio = abs(trial%modes(1, m)**2 - reference%modes(1, m)**2)/(1.0e-5_wp*largest)
            if (ratio > 1.0_wp) call disagree('values', ratio, 'frequency '//as_text(m)//': '//as_text(trial%modes(1, m), 8)// &
               & ' for '//as_text(reference%modes(1, m), 8))
         end do
      end subroutine compare_modes

   end subroutine compare

end module comparisons
