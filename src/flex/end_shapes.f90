!> Shapes that forces and moments at the ends of a beam make: the cubics that its supports allow. Vibration modes approach them
!> slowly, for at a free end they have no moment; a beam that is welded to others needs them. They join the modes, all are made
!> orthonormal in the lumped mass, and diagonalise the stiffness. Floor: flex. Source: doc/theory, eqs. (115), (116).
module limber_flex_end_shapes
   use limber_base_kinds, only: wp
   use limber_base_error, only: error_type, raise
   use limber_base_lapack, only: dsyev
   use limber_base_text, only: as_text
   use limber_flex_beam, only: bending_stiffness
   use limber_flex_mesh, only: beam_type, support_type, field_type, nodal_masses
   implicit none
   private
   public :: add_end_shapes

   !> Part of a shape that must be new
   real(wp), parameter :: new_part = 1.0e-6_wp

contains

   !> Adds the end shapes to the bending coordinates of a beam.
   subroutine add_end_shapes(beam, support, field, error)
      type(beam_type), intent(in) :: beam
      type(support_type), intent(in) :: support
      !> With its modes; receives the new coordinates in their place
      type(field_type), intent(inout) :: field
      !> There is no such shape, or LAPACK fails
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: w(:, :), theta(:, :), cubic(:, :), stiffness(:, :), omega2(:), work(:)
      real(wp) :: mass(0:beam%elements)
      integer :: modes, kept, rigid, count, j, info, last
      last = beam%elements
      modes = size(field%w, 2)
      mass = nodal_masses(beam)
      call allowed_cubics(support, beam%length, cubic)
      allocate (w(0:last, 2 + modes + size(cubic, 2)), theta(0:last, 2 + modes + size(cubic, 2)))
      ! The rigid-body motions that the supports leave come first: nothing of them may be in the shapes
      call rigid_motions(support, mass, field%s, w, theta, rigid)
      w(:, rigid + 1:rigid + modes) = field%w
      theta(:, rigid + 1:rigid + modes) = field%theta
      kept = rigid + modes
      do j = 1, size(cubic, 2)
         associate (x => field%s/beam%length)
            w(:, kept + 1) = cubic(1, j) + x*(cubic(2, j) + x*(cubic(3, j) + x*cubic(4, j)))
            theta(:, kept + 1) = (cubic(2, j) + x*(2*cubic(3, j) + 3*x*cubic(4, j)))/beam%length
         end associate
         call orthonormalise(mass, w(:, :kept), theta(:, :kept), w(:, kept + 1), theta(:, kept + 1), info)
         if (info == 0) kept = kept + 1
      end do
      if (kept == rigid + modes) then
         call raise(error, 'END SHAPES adds no coordinate to '//as_text(modes)// &
            & ' modes: both ends are clamped, or the modes are all'// &
            & ' that there are')
         return
      end if
      count = kept - rigid
      allocate (stiffness(count, count), omega2(count), work(8*count))
      call gather_stiffness(beam%ei, field%s, w(:, rigid + 1:kept), theta(:, rigid + 1:kept), stiffness)
      call dsyev('V', 'L', count, stiffness, count, omega2, work, size(work), info)
      if (info /= 0) then
         call raise(error, 'the shapes of the ends could not be made orthogonal (LAPACK info '//as_text(info)//')')
         return
      end if
      deallocate (field%w, field%theta, field%omega2_bending)
      allocate (field%w(0:last, count), field%theta(0:last, count), field%omega2_bending(count))
      field%w(:, :) = matmul(w(:, rigid + 1:kept), stiffness)
      field%theta(:, :) = matmul(theta(:, rigid + 1:kept), stiffness)
      field%omega2_bending(:) = omega2
   end subroutine add_end_shapes

   !> Writes the rigid-body motions that the supports leave, orthonormal in the mass, into the first columns.
   pure subroutine rigid_motions(support, mass, s, w, theta, number)
      type(support_type), intent(in) :: support
      !> Masses and places of the nodes (0:elements)
      real(wp), intent(in) :: mass(0:), s(0:)
      real(wp), intent(inout) :: w(0:, :), theta(0:, :)
      integer, intent(out) :: number
      integer :: info
      number = 0
      if (support%w_start .or. support%theta_start .or. support%w_end .or. support%theta_end) return
      w(:, 1) = 1.0_wp/sqrt(sum(mass))
      theta(:, 1) = 0.0_wp
      w(:, 2) = s
      theta(:, 2) = 1.0_wp
      call orthonormalise(mass, w(:, :1), theta(:, :1), w(:, 2), theta(:, 2), info)
      number = 2
   end subroutine rigid_motions

   !> Coefficients (4, number) of the cubics in x/length that keep the supports.
   pure subroutine allowed_cubics(support, length, cubic)
      type(support_type), intent(in) :: support
      real(wp), intent(in) :: length
      real(wp), allocatable, intent(out) :: cubic(:, :)
      !> Deflection and slope at both ends of a cubic, by Hermite's cubics
      real(wp), parameter :: hermite(4, 4) = reshape([1.0_wp, 0.0_wp, -3.0_wp, 2.0_wp, 0.0_wp, 1.0_wp, -2.0_wp, 1.0_wp, &
         & 0.0_wp, 0.0_wp, 3.0_wp, -2.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 1.0_wp], [4, 4])
      logical :: free(4)
      integer :: i, count
      free = .not. [support%w_start, support%theta_start, support%w_end, support%theta_end]
      count = 0
      allocate (cubic(4, size(pack(free, free))))
      do i = 1, 4
         if (.not. free(i)) cycle
         count = count + 1
         cubic(:, count) = length*hermite(:, i)
      end do
   end subroutine allowed_cubics

   !> Takes from a shape its part in others, which are orthonormal in the mass, and in the rigid-body motions that they leave out;
   !> brings it to unit modal mass. `info` is 1 if nothing is left.
   pure subroutine orthonormalise(mass, w, theta, new_w, new_theta, info)
      real(wp), intent(in) :: mass(:)
      !> Deflections and slopes at the nodes (nodes, number)
      real(wp), intent(in) :: w(:, :), theta(:, :)
      real(wp), intent(inout) :: new_w(:), new_theta(:)
      integer, intent(out) :: info
      real(wp) :: part, before
      integer :: k, pass
      before = sqrt(sum(mass*new_w**2))
      do pass = 1, 2
         do k = 1, size(w, 2)
            part = sum(mass*w(:, k)*new_w)
            new_w = new_w - part*w(:, k)
            new_theta = new_theta - part*theta(:, k)
         end do
      end do
      part = sqrt(sum(mass*new_w**2))
      info = merge(0, 1, part > new_part*before)
      if (info /= 0) return
      new_w = new_w/part
      new_theta = new_theta/part
   end subroutine orthonormalise

   !> Bending stiffness between shapes.
   pure subroutine gather_stiffness(ei, s, w, theta, stiffness)
      real(wp), intent(in) :: ei
      !> Places of the nodes (0:elements)
      real(wp), intent(in) :: s(0:)
      !> (0:elements, number)
      real(wp), intent(in) :: w(0:, :), theta(0:, :)
      !> (number, number)
      real(wp), intent(out) :: stiffness(:, :)
      real(wp) :: nodal(4, size(w, 2))
      integer :: e
      stiffness = 0.0_wp
      do e = 1, ubound(s, 1)
         nodal(1, :) = w(e - 1, :)
         nodal(2, :) = theta(e - 1, :)
         nodal(3, :) = w(e, :)
         nodal(4, :) = theta(e, :)
         stiffness = stiffness + matmul(transpose(nodal), matmul(bending_stiffness(ei, s(e) - s(e - 1)), nodal))
      end do
   end subroutine gather_stiffness

end module limber_flex_end_shapes
