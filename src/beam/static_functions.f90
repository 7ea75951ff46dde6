!> Static functions beside the modes: responses to loads and interface displacements. Responses to loads, shapes of an interface
!> that is displaced, and how all of them become coordinates: independent, orthonormal in the mass, diagonal in the stiffness. A
!> straight beam is a frame of one member here. Used before the time loop only. Floor: beam. Source: Craig and Bampton 1968; Yoo and
!> Haug 1986; doc/theory, eqs. (2.13), (2.19)-(2.21).
module limber_beam_static_functions
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_finite, only: dsyev
   use limber_base_text, only: as_text
   use limber_beam_plane_frame, only: frame_type, strain_energy, unit_load
   use limber_beam_frame_solver, only: solver_type, solve_static, project
   use limber_beam_modal_reduction, only: null_space
   implicit none
   private
   public :: attachment_type, attachment_loads, static_responses, remaining_responses, constraint_functions, add_functions, &
      & left_out_note

   !> Part of the strain energy of a function that may be lost with it
   real(wp), parameter, public :: may_be_lost = 1.0e-3_wp

   !> Least part of a function, in the mass norm, that those before it must not have for it to be kept
   real(wp), parameter :: new_part = 1.0e-7_wp

   !> A degree of freedom where something acts on a body
   type :: attachment_type
      !> Member of a frame; of a beam 1
      integer :: member = 1
      !> Coordinate along the member [length]
      real(wp) :: x = 0.0_wp
      !> 1, 2: force along the first or second axis of the body; 3: couple
      integer :: part = 1
   end type attachment_type

contains

   !> Unit loads at attachments (3, nodes, number); nothing where the supports take them.
   pure function attachment_loads(frame, attachments) result(load)
      type(frame_type), intent(in) :: frame
      type(attachment_type), intent(in) :: attachments(:)
      real(wp) :: load(3, size(frame%place, 2), size(attachments))
      integer :: i
      do i = 1, size(attachments)
         load(:, :, i) = unit_load(frame, attachments(i)%member, attachments(i)%x, attachments(i)%part)
         where (.not. frame%free) load(:, :, i) = 0.0_wp
      end do
   end function attachment_loads

   !> Displacements that loads make at rest, or in the rigid motion that they give a body that is free, eq. (2.13).
   subroutine static_responses(frame, solver, load, functions)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> (3, nodes, number), and so the functions
      real(wp), intent(in) :: load(:, :, :)
      real(wp), intent(out) :: functions(:, :, :)
      integer :: i
      do i = 1, size(load, 3)
         call solve_static(frame, solver, load(:, :, i), functions(:, :, i))
      end do
   end subroutine static_responses

   !> Displacements that loads make at rest without those of vibration modes: responses to what the modes leave of the loads. The
   !> difference of the responses would have few digits where the modes have nearly all of them.
   subroutine remaining_responses(frame, solver, shape, load, rests)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> Modes (3, nodes, n), orthonormal in the mass; loads (3, nodes, number), and so the responses
      real(wp), intent(in) :: shape(:, :, :), load(:, :, :)
      real(wp), allocatable, intent(out) :: rests(:, :, :)
      real(wp) :: rest(3, size(load, 2))
      integer :: i, j
      allocate (rests, mold=load)
      do i = 1, size(load, 3)
         rest = load(:, :, i)
         do j = 1, size(shape, 3)
            rest = rest - frame%mass*shape(:, :, j)*sum(shape(:, :, j)*rest)
         end do
         call solve_static(frame, solver, merge(rest, 0.0_wp, frame%free), rests(:, :, i))
      end do
   end subroutine remaining_responses

   !> Shapes of a body at rest when its interface is displaced, eq. (2.19): responses to those forces on the interface that balance
   !> each other. Without free rigid motions these are all forces.
   subroutine constraint_functions(frame, solver, load, functions)
      type(frame_type), intent(in) :: frame
      type(solver_type), intent(in) :: solver
      !> Unit loads of the interface (3, nodes, number)
      real(wp), intent(in) :: load(:, :, :)
      !> (3, nodes, number)
      real(wp), allocatable, intent(out) :: functions(:, :, :)
      real(wp) :: work(size(solver%motion, 3), size(load, 3)), response(3, size(load, 2), size(load, 3)), scale(size(load, 3))
      real(wp), allocatable :: balanced(:, :)
      integer :: i, k
      do i = 1, size(load, 3)
         do k = 1, size(work, 1)
            work(k, i) = sum(solver%motion(:, :, k)*load(:, :, i))
         end do
         scale(i) = 1.0_wp
         if (norm2(work(:, i)) > 0.0_wp) scale(i) = 1.0_wp/norm2(work(:, i))
         work(:, i) = work(:, i)*scale(i)
      end do
      allocate (balanced, source=null_space(work))
      call static_responses(frame, solver, load, response)
      allocate (functions(3, size(load, 2), size(balanced, 2)))
      functions = 0.0_wp
      do k = 1, size(balanced, 2)
         do i = 1, size(load, 3)
            functions(:, :, k) = functions(:, :, k) + response(:, :, i)*(scale(i)*balanced(i, k))
         end do
      end do
   end subroutine constraint_functions

   !> Adds functions to the modes, eqs. (2.20), (2.21): orthonormal in the mass, to the modes as well, and diagonal in the
   !> stiffness. Those that depend on others are left out. If they differ by displacements without mass the others take these as
   !> they please, eq. (2.21).
   subroutine add_functions(frame, functions, rests, whole, shape, omega2, left_out, lost, error)
      type(frame_type), intent(in) :: frame
      !> (3, nodes, number)
      real(wp), intent(in) :: functions(:, :, :)
      !> The functions without their parts in vibration modes, if these stay as they are; otherwise unallocated
      real(wp), allocatable, intent(in) :: rests(:, :, :)
      !> Whether the modes are no vibrations under the supports: then all coordinates become new ones
      logical, intent(in) :: whole
      !> Shapes and squared frequencies of the modes; receive those of all
      real(wp), allocatable, intent(inout) :: shape(:, :, :), omega2(:)
      !> Increased by the number of functions that depend on others; those without any displacement do not count
      integer, intent(inout) :: left_out
      !> Raised to the largest part of the strain energy of a function that is lost with it, as nothing of its own has mass
      real(wp), intent(inout) :: lost
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: own(:, :, :), all(:, :, :), value(:), massless(:, :, :)
      real(wp) :: norm, energy
      integer :: j, k, kept, pass, modes, idle
      modes = size(omega2)
      idle = 0
      allocate (own(3, size(frame%place, 2), modes + size(functions, 3)), massless(3, size(frame%place, 2), size(functions, 3)))
      own(:, :, :modes) = shape
      kept = modes
      if (whole) kept = 0
      do j = merge(1, modes + 1, whole), modes + size(functions, 3)
         if (j > modes) own(:, :, kept + 1) = functions(:, :, j - modes)
         if (j <= modes) own(:, :, kept + 1) = shape(:, :, j)
         if (.not. maxval(abs(own(:, :, kept + 1))) > 0.0_wp) cycle
         norm = sqrt(sum(frame%mass*own(:, :, kept + 1)**2))
         left_out = left_out + 1
         if (.not. norm > 0.0_wp) then
            if (strain_energy(frame, own(:, :, kept + 1), own(:, :, kept + 1)) > 0.0_wp) lost = 1.0_wp
            cycle
         end if
         own(:, :, kept + 1) = own(:, :, kept + 1)/norm
         energy = strain_energy(frame, own(:, :, kept + 1), own(:, :, kept + 1))
         if (j > modes .and. allocated(rests)) own(:, :, kept + 1) = rests(:, :, j - modes)/norm
         do pass = 1, 2
            do k = 1, kept
               call project(frame%mass, own(:, :, k), own(:, :, kept + 1))
            end do
         end do
         norm = sqrt(sum(frame%mass*own(:, :, kept + 1)**2))
         if (norm < new_part) then
            if (whole) call keep_idle(frame, own(:, :, kept + 1), energy, massless, idle)
            if (.not. whole) lost = max(lost, strain_energy(frame, own(:, :, kept + 1), own(:, :, kept + 1))/energy)
            cycle
         end if
         left_out = left_out - 1
         kept = kept + 1
         own(:, :, kept) = own(:, :, kept)/norm
      end do
      if (kept == modes .and. .not. whole) return
      do j = 1, idle
         do k = 1, kept
            own(:, :, k) = own(:, :, k) - massless(:, :, j)*strain_energy(frame, massless(:, :, j), own(:, :, k))
         end do
      end do
      allocate (all(3, size(frame%place, 2), kept), value(kept))
      modes = merge(0, modes, whole)
      all(:, :, :modes) = own(:, :, :modes)
      value(:modes) = omega2(:modes)
      call diagonalise(frame, own(:, :, modes + 1:kept), all(:, :, modes + 1:), value(modes + 1:), error)
      if (allocated(error)) return
      call move_alloc(all, shape)
      call move_alloc(value, omega2)
   end subroutine add_functions

   !> Notes displacements without mass, orthonormal in the stiffness, unless they are none.
   subroutine keep_idle(frame, field, energy, massless, idle)
      type(frame_type), intent(in) :: frame
      !> (3, nodes), and the strain energy that it is to be compared with
      real(wp), intent(in) :: field(:, :), energy
      !> (3, nodes, number), so many of which are in use
      real(wp), intent(inout) :: massless(:, :, :)
      integer, intent(inout) :: idle
      real(wp) :: rest(3, size(field, 2)), norm
      integer :: k, pass
      if (idle == size(massless, 3)) return
      rest = field
      do pass = 1, 2
         do k = 1, idle
            rest = rest - massless(:, :, k)*strain_energy(frame, massless(:, :, k), rest)
         end do
      end do
      norm = strain_energy(frame, rest, rest)
      if (norm <= (10*new_part)**2*energy) return
      idle = idle + 1
      massless(:, :, idle) = rest/sqrt(norm)
   end subroutine keep_idle

   !> Turns functions of unit mass among each other so that they do not couple in the stiffness, eq. (2.21).
   subroutine diagonalise(frame, own, shape, omega2, error)
      type(frame_type), intent(in) :: frame
      !> (3, nodes, number), and so the result
      real(wp), intent(in) :: own(:, :, :)
      real(wp), intent(out) :: shape(:, :, :), omega2(:)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: stiffness(size(own, 3), size(own, 3)), work(max(1, 8*size(own, 3)))
      integer :: i, j, n, info
      n = size(own, 3)
      do j = 1, n
         do i = j, n
            stiffness(i, j) = strain_energy(frame, own(:, :, i), own(:, :, j))
         end do
      end do
      call dsyev('V', 'L', n, stiffness, max(1, n), omega2, work, size(work), info)
      if (info /= 0) then
         call raise(error, 'the static functions could not be made orthogonal (LAPACK info '//as_text(info)//')')
         return
      end if
      shape = 0.0_wp
      do j = 1, n
         do i = 1, n
            shape(:, :, j) = shape(:, :, j) + own(:, :, i)*stiffness(i, j)
         end do
      end do
   end subroutine diagonalise

   !> Says how many functions were left out; empty if none were.
   pure function left_out_note(left_out, kind) result(text)
      integer, intent(in) :: left_out
      !> 'bending ', 'axial ', ''
      character(*), intent(in) :: kind
      character(:), allocatable :: text
      text = ''
      if (left_out == 1) text = '1 '//kind//'function depends on others and is left out'
      if (left_out > 1) text = as_text(left_out)//' '//kind//'functions depend on others and are left out'
   end function left_out_note

end module limber_beam_static_functions
