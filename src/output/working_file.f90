!> File under a working name until it is whole. Copies of it take that name now and then, and it takes the name itself at its end.
!> Floor: output.
!>
!> HDF5 changes a file in place, in no order that could be relied upon: a program that is killed while it does so leaves a file that
!> may not open. A copy that takes the place of the one before by a change of names is the one protection that asks nothing of HDF5
!> or of the file system. Copies are made at longer and longer intervals as the file grows, so that they take a twentieth of
!> the time at most.
module limber_output_working_file
   use limber_base_error, only: error_type, raise, status_deck
   use limber_base_files, only: rename_file, remove_file, copy_file, is_folder, may_write, kind_of_path, path_other
   use limber_base_kinds, only: wp, long
   use limber_output_own_files, only: check_own, remove_own
   implicit none
   private
   public :: working_file_type, working_name

   !> Intervals between copies, in times that a copy takes
   real(wp), parameter :: rest = 20.0_wp

   !> The names of a file that is being written
   type :: working_file_type
      !> Its own name, and the one under which it is written
      character(:), allocatable :: path, working
      !> Whether its own name has stood for something else that may be replaced; whether a copy has that name now
      logical :: replaces = .false., published = .false.
      !> Wall time between copies at least [s]
      real(wp) :: pause = 0.0_wp
   contains
      procedure :: begin, resume, publish, put_in_place, drop
   end type working_file_type

contains

   !> Name under which a file is written.
   pure function working_name(path) result(name)
      character(*), intent(in) :: path
      character(:), allocatable :: name
      name = path//'.running'
   end function working_name

   !> Looks whether a file can be made. Nothing is made yet.
   subroutine begin(self, path, overwrite, error)
      class(working_file_type), intent(inout) :: self
      !> Its name
      character(*), intent(in) :: path
      !> Whether a file that has the name may be replaced
      logical, intent(in) :: overwrite
      !> Allocated if it may not, or cannot
      type(error_type), allocatable, intent(out) :: error
      logical :: exists, writable
      self%path = path
      self%working = working_name(path)
      self%replaces = overwrite
      self%published = .false.
      self%pause = 0.0_wp
      inquire (file=path, exist=exists)
      writable = may_write(path)
      if (is_folder(path)) then
         call raise(error, 'cannot create '//path//': Is a directory', status_deck)
      else if (kind_of_path(path) == path_other) then
         call raise(error, 'cannot write '//path//': it is a pipe or a device, not a file', status_deck)
      else if (exists .and. .not. overwrite) then
         call raise(error, path//' exists; give --force to overwrite it or -o for another name', status_deck)
      else if (exists .and. .not. writable) then
         call raise(error, 'cannot overwrite '//path//': Permission denied', status_deck)
      end if
      if (.not. allocated(error)) call check_own(self%working, '', error)
      if (.not. allocated(error)) call check_own(path//'.new', '', error)
   end subroutine begin

   !> Takes a copy of a file that is there, to go on with.
   subroutine resume(self, path, error)
      class(working_file_type), intent(inout) :: self
      character(*), intent(in) :: path
      !> Allocated if it cannot be copied; it is left as it is in any case
      type(error_type), allocatable, intent(out) :: error
      character(:), allocatable :: trouble
      call self%begin(path, .true., error)
      if (allocated(error)) return
      call copy_file(path, self%working, trouble)
      if (trouble /= '') call raise(error, 'cannot copy '//path//' to '//self%working//': '//trouble, status_deck)
      self%published = .not. allocated(error)
   end subroutine resume

   !> Gives a copy of what has been written so far the name of the file. The copy before stays in its place if that fails.
   subroutine publish(self, trouble, error)
      class(working_file_type), intent(inout) :: self
      !> Why there is no copy, such as a full disk: it may do later; empty if there is
      character(:), allocatable, intent(out) :: trouble
      !> Allocated if there can be none any more
      type(error_type), allocatable, intent(out) :: error
      integer(long) :: before, after, rate
      logical :: ok
      trouble = ''
      call check_names(self, error)
      if (allocated(error)) return
      call system_clock(before)
      call copy_file(self%working, self%path//'.new', trouble)
      if (trouble == '') then
         call rename_file(self%path//'.new', self%path, ok)
         if (.not. ok) trouble = 'cannot give '//self%path//'.new its name'
         if (.not. ok) call remove_file(self%path//'.new')
      end if
      call system_clock(after, rate)
      self%pause = rest*real(after - before, wp)/real(rate, wp)
      if (trouble == '') self%published = .true.
   end subroutine publish

   !> Gives the file its name, once it is closed.
   subroutine put_in_place(self, error)
      class(working_file_type), intent(inout) :: self
      !> Allocated if that cannot be done; it is then found under its other name, if at all
      type(error_type), allocatable, intent(out) :: error
      logical :: ok
      call check_names(self, error)
      if (allocated(error)) return
      call rename_file(self%working, self%path, ok)
      if (ok) then
         self%published = .true.
         ! What a kill has left while a copy was made
         call remove_own(self%path//'.new', '')
      else
         call raise(error, 'cannot give '//self%working//' the name '//self%path//'; the results are in the former')
      end if
   end subroutine put_in_place

   !> Whether the file is where it was made, and nobody else has taken its name.
   subroutine check_names(self, error)
      class(working_file_type), intent(in) :: self
      type(error_type), allocatable, intent(out) :: error
      logical :: exists
      inquire (file=self%working, exist=exists)
      if (.not. exists) then
         call raise(error, self%working//' is gone: somebody has removed it, or its folder')
         return
      end if
      if (self%published .or. self%replaces) return
      inquire (file=self%path, exist=exists)
      if (exists) call raise(error, self%path//' was made by somebody else while '//self%working// &
         & ' was written; it is left as it is')
   end subroutine check_names

   !> Removes what was written under the other name: it is damaged.
   subroutine drop(self)
      class(working_file_type), intent(in) :: self
      call remove_file(self%working)
   end subroutine drop

end module limber_output_working_file
